//! Rößler's stochastic Runge-Kutta methods for additive noise: the step, and the order conditions.

use crate::field::{FieldIncrement, FieldSde, Workspace};
use crate::integrator::apply;
use crate::noise::Increment;
use crate::system::{Additive, Sde};

/// The coefficients of a method with `S` stages.
///
/// $$ H_i = X_n + h \sum_j A^0_{ij} f(t_n + c^0_j h, H_j) + \frac Ih \sum_j B^0_{ij} g(t_n + c^1_j h), $$
/// $$ X_{n+1} = X_n + h \sum_i a_i f(t_n + c^0_i h, H_i) +
///    \sum_i \left(b^1_i w + b^2_i \frac Ih\right) g(t_n + c^1_i h), \quad I = h \left(\tfrac12 w + H\right) $$
///
/// Source: Rößler 2010, Runge-Kutta methods for the strong approximation of solutions of stochastic differential
/// equations, eq 5.1 and theorem 5.1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tableau<const S: usize> {
    pub(crate) a: [f64; S],
    pub(crate) a0: [[f64; S]; S],
    pub(crate) b0: [[f64; S]; S],
    pub(crate) b1: [f64; S],
    pub(crate) b2: [f64; S],
    pub(crate) c0: [f64; S],
    pub(crate) c1: [f64; S],
}

impl<const S: usize> Tableau<S> {
    /// One step of a small state.
    #[inline]
    pub(crate) fn step<Y, const D: usize, const M: usize>(
        &self,
        system: &Y,
        (t, dt): (f64, f64),
        dw: &Increment<M>,
        x: &mut [f64; D],
    ) where
        Y: Sde<D, M, Noise = Additive> + ?Sized,
    {
        // I/h
        let mean: [f64; M] = std::array::from_fn(|m| 0.5 * dw.brownian[m] + dw.space_time_area[m]);
        let (mut kick, mut mean_kick) = ([[0.0; D]; S], [[0.0; D]; S]);
        for j in 0..S {
            let g = system.noise(t + self.c1[j] * dt, x);
            (kick[j], mean_kick[j]) = (apply(&g, &dw.brownian), apply(&g, &mean));
        }
        let mut drift = [[0.0; D]; S];
        for i in 0..S {
            let mut stage = *x;
            for j in 0..S {
                for k in 0..D {
                    stage[k] += self.a0[i][j] * dt * drift[j][k] + self.b0[i][j] * mean_kick[j][k];
                }
            }
            drift[i] = system.drift(t + self.c0[i] * dt, &stage);
        }
        for i in 0..S {
            for k in 0..D {
                x[k] += self.a[i] * dt * drift[i][k]
                    + self.b1[i] * kick[i][k]
                    + self.b2[i] * mean_kick[i][k];
            }
        }
    }

    /// One step of a field.
    pub(crate) fn field_step<Y: FieldSde + ?Sized>(
        &self,
        system: &Y,
        (t, dt): (f64, f64),
        dw: FieldIncrement<'_>,
        x: &mut [f64],
        workspace: &mut Workspace,
    ) {
        let n = x.len();
        let (stage, drifts) = workspace.flat((S + 1) * n).split_at_mut(n);
        let intensity = self.c1.map(|c| system.intensity(t + c * dt));
        let weighted =
            |weights: &[f64; S]| weights.iter().zip(&intensity).map(|(b, g)| b * g).sum::<f64>();
        for i in 0..S {
            let by_mean = weighted(&self.b0[i]);
            for k in 0..n {
                stage[k] = x[k] + by_mean * (0.5 * dw.brownian[k] + dw.space_time_area[k]);
            }
            let (known, rest) = drifts.split_at_mut(i * n);
            for (j, drift) in known.chunks_exact(n.max(1)).enumerate() {
                let by_drift = self.a0[i][j] * dt;
                if by_drift != 0.0 {
                    stage.iter_mut().zip(drift).for_each(|(y, f)| *y += by_drift * f);
                }
            }
            system.drift(t + self.c0[i] * dt, stage, &mut rest[..n]);
        }
        let (by_w, by_mean) = (weighted(&self.b1), weighted(&self.b2));
        for k in 0..n {
            let drift: f64 = (0..S).map(|i| self.a[i] * drifts[i * n + k]).sum();
            let (w, area) = (dw.brownian[k], dw.space_time_area[k]);
            x[k] += dt * drift + by_w * w + by_mean * (0.5 * w + area);
        }
    }
}

/// Implements the integrator traits of small states and of fields for a tableau.
macro_rules! integrate_by_tableau {
    ($method:ty) => {
        impl<S, const D: usize, const M: usize> $crate::integrator::Integrator<S, D, M> for $method
        where
            S: $crate::system::Sde<D, M, Noise = $crate::system::Additive> + ?Sized,
        {
            type Memory = ();

            #[inline]
            fn step(
                &self,
                system: &S,
                t: f64,
                dt: f64,
                dw: &$crate::noise::Increment<M>,
                x: &mut [f64; D],
                _memory: &mut (),
            ) -> Result<(), $crate::error::StepError> {
                TABLEAU.step(system, (t, dt), dw, x);
                Ok(())
            }
        }

        impl $crate::field::FieldIntegrator for $method {
            type Memory = ();

            fn step<S: $crate::field::FieldSde + ?Sized>(
                &self,
                system: &S,
                t: f64,
                dt: f64,
                dw: $crate::field::FieldIncrement<'_>,
                x: &mut [f64],
                workspace: &mut $crate::field::Workspace,
                _memory: &mut (),
            ) -> Result<(), $crate::error::StepError> {
                TABLEAU.field_step(system, (t, dt), dw, x, workspace);
                Ok(())
            }
        }
    };
}
pub(crate) use integrate_by_tableau;

#[cfg(test)]
pub(crate) mod conditions {
    use super::Tableau;

    /// Residual of each condition of strong order 1.5; the last two kinds fix the time of a stage.
    pub(crate) fn residuals<const S: usize>(tableau: &Tableau<S>) -> Vec<(String, f64)> {
        let Tableau { a, a0, b0, b1, b2, c0, c1 } = tableau;
        let dot = |x: &[f64; S], y: &[f64; S]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let sum = |x: &[f64; S]| x.iter().sum::<f64>();
        let (a0_e, b0_e) = (a0.map(|row| sum(&row)), b0.map(|row| sum(&row)));
        let mut all = vec![
            ("sum a = 1".into(), sum(a) - 1.0),
            ("sum b1 = 1".into(), sum(b1) - 1.0),
            ("sum b2 = 0".into(), sum(b2)),
            ("b1.c1 = 1".into(), dot(b1, c1) - 1.0),
            ("b2.c1 = -1".into(), dot(b2, c1) + 1.0),
            ("a.A0e = 1/2".into(), dot(a, &a0_e) - 0.5),
            ("a.B0e = 1".into(), dot(a, &b0_e) - 1.0),
            ("a.(B0e)^2 = 3/2".into(), dot(a, &b0_e.map(|b| b * b)) - 1.5),
        ];
        for i in 0..S {
            all.push((format!("A0e = c0, stage {i}"), a0_e[i] - c0[i]));
        }
        all
    }

    /// Checks that all conditions hold, and that no coefficient can change without breaking one.
    ///
    /// Each coefficient is changed by 0.01, except those without influence (`c1_i` where `b1_i = b2_i = 0`).
    pub(crate) fn hold_and_pin_every_coefficient<const S: usize>(tableau: Tableau<S>) {
        const ROUNDOFF: f64 = 1e-14;
        let broken = |tableau: &Tableau<S>| {
            residuals(tableau).into_iter().filter(|(_, left)| left.abs() > ROUNDOFF).count()
        };
        assert_eq!(broken(&tableau), 0, "{:?}", residuals(&tableau));
        let mut n_mutants = 0;
        let mut expect_broken = |what: &str, mutate: &dyn Fn(&mut Tableau<S>)| {
            let mut mutant = tableau;
            mutate(&mut mutant);
            assert!(broken(&mutant) > 0, "{what} is not pinned");
            n_mutants += 1;
        };
        for i in 0..S {
            expect_broken("a", &|m| m.a[i] += 0.01);
            expect_broken("b1", &|m| m.b1[i] += 0.01);
            expect_broken("b2", &|m| m.b2[i] += 0.01);
            expect_broken("c0", &|m| m.c0[i] += 0.01);
            if tableau.b1[i] != 0.0 || tableau.b2[i] != 0.0 {
                expect_broken("c1", &|m| m.c1[i] += 0.01);
            }
            for j in 0..i {
                expect_broken("a0", &|m| m.a0[i][j] += 0.01);
                expect_broken("b0", &|m| m.b0[i][j] += 0.01);
            }
        }
        // The error in a published table: the sign of b2.
        expect_broken("the sign of b2", &|m| m.b2 = m.b2.map(|b| -b));
        assert!(n_mutants > 8);
    }
}
