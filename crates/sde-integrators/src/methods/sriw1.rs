//! SRIW1: strong order 1.5 for diagonal noise.

use crate::diagonal::DiagonalSde;
use crate::error::StepError;
use crate::integrator::Integrator;
use crate::noise::streams::Increment;

/// Rößler's SRIW1, for diagonal noise.
///
/// $$ H^0_i = X_n + h \sum_j A^0_{ij} f(t_n + c^0_j h, H^0_j) +
///    \frac{I_{10}}h \sum_j B^0_{ij} b(t_n + c^1_j h, H^1_j), $$
/// $$ H^1_i = X_n + h \sum_j A^1_{ij} f(t_n + c^0_j h, H^0_j) + \sqrt h \sum_j B^1_{ij} b(t_n + c^1_j h, H^1_j), $$
/// $$ X_{n+1} = X_n + h \sum_i a_i f(t_n + c^0_i h, H^0_i) + \sum_i \left(b^1_i w + b^2_i \frac{I_{11}}{\sqrt h} +
///    b^3_i \frac{I_{10}}h + b^4_i \frac{I_{111}}h\right) b(t_n + c^1_i h, H^1_i), $$
///
/// per state, with `I11 = (w^2 - h)/2`, `I10 = h (w/2 + H)` and `I111 = (w^3 - 3 h w)/6`. Solves the Ito equation
/// `dX_i = f_i dt + b_i(t, X_i) dB_i`. Symbols: `h` = `dt`, `w` = `dw.brownian`, `H` = `dw.space_time_area`. It
/// evaluates `b` alone, not its derivative.
///
/// Order (diagonal noise): strong 1.5, weak 2. With several states the stages couple their drifts only to the order
/// that diagonal noise requires.
///
/// Stable for: in the mean square of `dX = l X dt + m X dB`, `|l| h` up to 2, 1.54, 1.16, 0.78, 0.43 at `m^2/(2 |l|)`
/// = 0, 0.25, 0.5, 0.75, 0.9, by quadrature. For strong noise the region exceeds those of Milstein and Euler-Maruyama.
///
/// Cost: two drift and four intensity evaluations per step.
///
/// Source: Rößler 2010, table 6.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sriw1;

/// The coefficients; stages three and four use the drift of the first, since their `H^0` is `X_n`.
#[derive(Debug, Clone, Copy)]
struct Tableau {
    a: [f64; 4],
    b: [[f64; 4]; 4],
    a0: [[f64; 4]; 4],
    b0: [[f64; 4]; 4],
    a1: [[f64; 4]; 4],
    b1: [[f64; 4]; 4],
    c0: [f64; 4],
    c1: [f64; 4],
}

const TABLEAU: Tableau = Tableau {
    a: [1.0 / 3.0, 2.0 / 3.0, 0.0, 0.0],
    b: [
        [-1.0, 4.0 / 3.0, 2.0 / 3.0, 0.0],
        [-1.0, 4.0 / 3.0, -1.0 / 3.0, 0.0],
        [2.0, -4.0 / 3.0, -2.0 / 3.0, 0.0],
        [-2.0, 5.0 / 3.0, -2.0 / 3.0, 1.0],
    ],
    a0: [[0.0; 4], [0.75, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]],
    b0: [[0.0; 4], [1.5, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]],
    a1: [[0.0; 4], [0.25, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.25, 0.0]],
    b1: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [-5.0, 3.0, 0.5, 0.0]],
    c0: [0.0, 0.75, 0.0, 0.0],
    c1: [0.0, 0.25, 1.0, 0.25],
};

impl Tableau {
    #[inline]
    fn step<S, const D: usize>(
        &self,
        system: &S,
        (t, dt): (f64, f64),
        dw: &Increment<D>,
        x: &mut [f64; D],
    ) where
        S: DiagonalSde<D> + ?Sized,
    {
        let root = dt.sqrt();
        // w, I11/sqrt(h), I10/h, I111/h
        let integrals: [[f64; 4]; D] = std::array::from_fn(|k| {
            let (w, area) = (dw.brownian[k], dw.space_time_area[k]);
            let square = w * w - dt;
            // A step of zero length has no noise.
            let per_step = if dt > 0.0 { 1.0 / dt } else { 0.0 };
            [
                w,
                0.5 * square * root * per_step,
                0.5 * w + area,
                w * (square - 2.0 * dt) / 6.0 * per_step,
            ]
        });
        let first = system.drift(t, x);
        let (mut drift, mut intensity) = ([[0.0; D]; 4], [[0.0; D]; 4]);
        for i in 0..4 {
            let (mut stage_0, mut stage_1) = (*x, *x);
            for j in 0..i {
                for k in 0..D {
                    stage_0[k] += self.a0[i][j] * dt * drift[j][k]
                        + self.b0[i][j] * integrals[k][2] * intensity[j][k];
                    stage_1[k] +=
                        self.a1[i][j] * dt * drift[j][k] + self.b1[i][j] * root * intensity[j][k];
                }
            }
            drift[i] = if i == 1 { system.drift(t + self.c0[i] * dt, &stage_0) } else { first };
            intensity[i] = system.intensity(t + self.c1[i] * dt, &stage_1);
        }
        for k in 0..D {
            for i in 0..4 {
                let kick: f64 = (0..4).map(|r| self.b[r][i] * integrals[k][r]).sum();
                x[k] += self.a[i] * dt * drift[i][k] + kick * intensity[i][k];
            }
        }
    }
}

impl<S, const D: usize> Integrator<S, D, D> for Sriw1
where
    S: DiagonalSde<D> + ?Sized,
{
    type Memory = ();

    #[inline]
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<D>,
        x: &mut [f64; D],
        _memory: &mut (),
    ) -> Result<(), StepError> {
        TABLEAU.step(system, (t, dt), dw, x);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Row = [f64; 4];

    fn dot(x: &Row, y: &Row) -> f64 {
        x.iter().zip(y).map(|(x, y)| x * y).sum()
    }

    fn times(matrix: &[Row; 4], x: &Row) -> Row {
        matrix.map(|row| dot(&row, x))
    }

    /// Rößler 2010, theorem 5.2: the residual of each condition of strong order 1.5, and the time of each stage.
    fn residuals(tableau: &Tableau) -> Vec<f64> {
        let Tableau { a, b, a0, b0, a1, b1, c0, c1 } = tableau;
        let e = [1.0; 4];
        let (a0_e, b0_e) = (times(a0, &e), times(b0, &e));
        let (a1_e, b1_e) = (times(a1, &e), times(b1, &e));
        let square = |x: &Row| x.map(|x| x * x);
        let mut all = vec![
            dot(a, &e) - 1.0,
            dot(a, &a0_e) - 0.5,
            dot(a, &b0_e) - 1.0,
            dot(a, &square(&b0_e)) - 1.5,
        ];
        let expected = [
            (&e, [1.0, 0.0, 0.0, 0.0]),
            (&b1_e, [0.0, 1.0, 0.0, 0.0]),
            (&a1_e, [1.0, 0.0, -1.0, 0.0]),
            (&square(&b1_e), [1.0, 0.0, -1.0, 2.0]),
            (&times(b1, &b1_e), [0.0, 0.0, 0.0, 1.0]),
        ];
        for (vector, values) in expected {
            all.extend(b.iter().zip(values).map(|(b, value)| dot(b, vector) - value));
        }
        let mixed = times(a1, &b0_e);
        all.push(0.5 * dot(&b[0], &mixed) + dot(&b[2], &mixed) / 3.0);
        all.extend(a0_e.iter().zip(c0).map(|(sum, c)| sum - c));
        all.extend(a1_e.iter().zip(c1).map(|(sum, c)| sum - c));
        all
    }

    fn broken(tableau: &Tableau) -> usize {
        residuals(tableau).iter().filter(|left| left.abs() > 1e-13).count()
    }

    #[test]
    fn the_conditions_of_order_hold() {
        assert_eq!(broken(&TABLEAU), 0, "{:?}", residuals(&TABLEAU));
        assert_eq!(residuals(&TABLEAU).len(), 25 + 8);
    }

    /// Each coefficient that affects the step is changed by 0.01.
    ///
    /// `B0` of stages with weight `a` zero whose drift no later stage uses does not affect it.
    #[test]
    fn the_conditions_pin_every_coefficient() {
        let mut n_mutants = 0;
        let mut expect_broken = |what: &str, mutate: &dyn Fn(&mut Tableau)| {
            let mut mutant = TABLEAU;
            mutate(&mut mutant);
            assert!(broken(&mutant) > 0, "{what} is not pinned");
            n_mutants += 1;
        };
        for i in 0..4 {
            expect_broken("a", &|m| m.a[i] += 0.01);
            expect_broken("c0", &|m| m.c0[i] += 0.01);
            expect_broken("c1", &|m| m.c1[i] += 0.01);
            for j in 0..4 {
                expect_broken("b", &|m| m.b[i][j] += 0.01);
            }
            for j in 0..i {
                expect_broken("a0", &|m| m.a0[i][j] += 0.01);
                expect_broken("a1", &|m| m.a1[i][j] += 0.01);
                expect_broken("b1", &|m| m.b1[i][j] += 0.01);
            }
        }
        expect_broken("b0", &|m| m.b0[1][0] += 0.01);
        assert_eq!(n_mutants, 12 + 16 + 18 + 1);
    }
}
