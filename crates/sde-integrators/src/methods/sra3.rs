//! SRA3: three drift evaluations, strong order 1.5 for additive noise and order 3 without noise.

use crate::error::StepError;
use crate::integrator::{Integrator, apply};
use crate::noise::streams::Increment;
use crate::system::{Additive, Sde};

/// Rößler's SRA3, for weak additive noise.
///
/// $$ H_2 = X_n + h f(t_n, X_n), \qquad
///    H_3 = X_n + \tfrac14 h \left(f(t_n, X_n) + f(t_{n+1}, H_2)\right) +
///    \frac Ih \left(g(t_{n+1}) + \tfrac12 g(t_n)\right), $$
/// $$ X_{n+1} = X_n + \tfrac16 h \left(f(t_n, X_n) + f(t_{n+1}, H_2) + 4 f(t_n + \tfrac12 h, H_3)\right) +
///    g(t_{n+1}) w + (g(t_n) - g(t_{n+1})) \frac Ih $$
///
/// with `I = h (w/2 + H)`. Solves `dX = f(t, X) dt + g(t) dB`; Ito and Stratonovich agree. Symbols: `h` = `dt`, `w` =
/// `dw.brownian`, `H` = `dw.space_time_area`.
///
/// Order (additive noise): strong 1.5, weak 2; 3 without noise, which is visible for weak noise.
///
/// Stable for: `|1 + z + z^2/2 + z^3/6| < 1` with `z = h l`; an undamped oscillator for `h omega < sqrt(3)`.
///
/// Source: Rößler 2010, table 6.3. One published implementation has the wrong sign of `b2`, which lowers the order to
/// 1 for time-dependent noise; the test of the conditions detects that error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sra3;

/// The coefficients.
///
/// $$ H_i = X_n + h \sum_j A^0_{ij} f(t_n + c^0_j h, H_j) + \frac Ih \sum_j B^0_{ij} g(t_n + c^1_j h), $$
/// $$ X_{n+1} = X_n + h \sum_i a_i f(t_n + c^0_i h, H_i) +
///    \sum_i \left(b^1_i w + b^2_i \frac Ih\right) g(t_n + c^1_i h), \quad I = h \left(\tfrac12 w + H\right) $$
///
/// Source: Rößler 2010, Runge-Kutta methods for the strong approximation of solutions of stochastic differential
/// equations, eq 5.1 and theorem 5.1.
#[derive(Debug, Clone, Copy)]
struct Tableau {
    a: [f64; 3],
    a0: [[f64; 3]; 3],
    b0: [[f64; 3]; 3],
    b1: [f64; 3],
    b2: [f64; 3],
    c0: [f64; 3],
    c1: [f64; 3],
}

impl Tableau {
    /// One step.
    #[inline]
    fn step<Y, const D: usize, const M: usize>(
        &self,
        system: &Y,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
    ) where
        Y: Sde<D, M, Noise = Additive> + ?Sized,
    {
        // I/h
        let mean: [f64; M] = std::array::from_fn(|m| 0.5 * dw.brownian[m] + dw.space_time_area[m]);
        let (mut kick, mut mean_kick) = ([[0.0; D]; 3], [[0.0; D]; 3]);
        for j in 0..3 {
            let g = system.noise(t + self.c1[j] * dt, x);
            (kick[j], mean_kick[j]) = (apply(&g, &dw.brownian), apply(&g, &mean));
        }
        let mut drift = [[0.0; D]; 3];
        for i in 0..3 {
            let mut stage = *x;
            for j in 0..3 {
                for k in 0..D {
                    stage[k] += self.a0[i][j] * dt * drift[j][k] + self.b0[i][j] * mean_kick[j][k];
                }
            }
            drift[i] = system.drift(t + self.c0[i] * dt, &stage);
        }
        for i in 0..3 {
            for k in 0..D {
                x[k] += self.a[i] * dt * drift[i][k]
                    + self.b1[i] * kick[i][k]
                    + self.b2[i] * mean_kick[i][k];
            }
        }
    }
}

const TABLEAU: Tableau = Tableau {
    a: [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    a0: [[0.0; 3], [1.0, 0.0, 0.0], [0.25, 0.25, 0.0]],
    b0: [[0.0; 3], [0.0; 3], [1.0, 0.5, 0.0]],
    b1: [1.0, 0.0, 0.0],
    b2: [-1.0, 1.0, 0.0],
    c0: [0.0, 1.0, 0.5],
    c1: [1.0, 0.0, 0.0],
};

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for Sra3
where
    S: Sde<D, M, Noise = Additive> + ?Sized,
{
    type Memory = ();

    #[inline]
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        _memory: &mut (),
    ) -> Result<(), StepError> {
        TABLEAU.step(system, t, dt, dw, x);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residual of each condition of strong order 1.5; the last two kinds fix the time of a stage.
    fn residuals(tableau: &Tableau) -> Vec<(String, f64)> {
        let Tableau { a, a0, b0, b1, b2, c0, c1 } = tableau;
        let dot = |x: &[f64; 3], y: &[f64; 3]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let sum = |x: &[f64; 3]| x.iter().sum::<f64>();
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
        for i in 0..3 {
            all.push((format!("A0e = c0, stage {i}"), a0_e[i] - c0[i]));
        }
        all
    }

    /// Checks that all conditions hold, and that no coefficient can change without breaking one.
    ///
    /// Each coefficient is changed by 0.01, except those without influence (`c1_i` where `b1_i = b2_i = 0`).
    #[test]
    fn the_conditions_of_order_hold_and_pin_every_coefficient() {
        const ROUNDOFF: f64 = 1e-14;
        let tableau = TABLEAU;
        let broken = |tableau: &Tableau| {
            residuals(tableau).into_iter().filter(|(_, left)| left.abs() > ROUNDOFF).count()
        };
        assert_eq!(broken(&tableau), 0, "{:?}", residuals(&tableau));
        let mut n_mutants = 0;
        let mut expect_broken = |what: &str, mutate: &dyn Fn(&mut Tableau)| {
            let mut mutant = tableau;
            mutate(&mut mutant);
            assert!(broken(&mutant) > 0, "{what} is not pinned");
            n_mutants += 1;
        };
        for i in 0..3 {
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
