//! The exact law of a linear system with constant coefficients.

use crate::error::Error;
use crate::matrix::{Matrix, add, norm, product, scaled, transposed};

/// What a time does to the law of `dX = F X dt + G dB`: `X(t) = E X(0) + N(0, Q)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Transition<const D: usize> {
    /// `E = exp(F t)`.
    pub(crate) matrix: Matrix<D>,
    /// `Q`, the integral of `exp(F s) G G^T exp(F s)^T` from 0 to `t`.
    pub(crate) covariance: Matrix<D>,
}

/// Terms of the series over a time in which `F` does not exceed one half: the last is below 1e-16 of the first.
const TERMS: u32 = 16;
/// Most doublings on the way to a stationary law. After `2^40` first times a mode that does not decay has lost 1e-4 by
/// roundoff, one with a damping ratio of 1e-10 all.
const MOST_DOUBLINGS: u32 = 40;
/// A transition below this has forgotten where it started, squared and to the last digit.
const FORGOTTEN: f64 = 1e-12;

impl<const D: usize> Transition<D> {
    /// Over the time `t`, from `F` and `G G^T`: Taylor series over a part of it, then doubled.
    pub(crate) fn over(f: &Matrix<D>, noise: &Matrix<D>, t: f64) -> Self {
        let (mut part, mut doublings) = (t, 0);
        while norm(f) * part > 0.5 {
            part *= 0.5;
            doublings += 1;
        }
        let mut transition = Self::series(f, noise, part);
        for _ in 0..doublings {
            transition = transition.doubled();
        }
        transition
    }

    /// The covariance that stays.
    pub(crate) fn stationary(
        name: &'static str,
        f: &Matrix<D>,
        noise: &Matrix<D>,
    ) -> Result<Matrix<D>, Error> {
        let mut time = 0.5 / norm(f).max(f64::MIN_POSITIVE);
        let mut transition = Self::series(f, noise, time);
        for _ in 0..MOST_DOUBLINGS {
            if norm(&transition.matrix) < FORGOTTEN {
                return Ok(transition.covariance);
            }
            transition = transition.doubled();
            time *= 2.0;
        }
        let value = norm(&transition.matrix);
        Err(Error::NoStationaryLaw { name, time, value, limit: FORGOTTEN })
    }

    /// The covariance of `X(t)` from that of `X(0)`.
    pub(crate) fn of_covariance(&self, start: &Matrix<D>) -> Matrix<D> {
        add(&congruence(&self.matrix, start), &self.covariance)
    }

    fn series(f: &Matrix<D>, noise: &Matrix<D>, t: f64) -> Self {
        let mut matrix = [[0.0; D]; D];
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] = 1.0;
        }
        // Terms F^k t^k/k! of E, and t^(k+1)/(k+1)! of the k-th derivative of the integrand, X -> F X + X F^T.
        let (mut term, mut derivative) = (matrix, scaled(noise, t));
        let mut covariance = derivative;
        for k in 1..=TERMS {
            let k = f64::from(k);
            term = scaled(&product(f, &term), t / k);
            matrix = add(&matrix, &term);
            let moved = product(f, &derivative);
            derivative = scaled(&add(&moved, &transposed(&moved)), t / (k + 1.0));
            covariance = add(&covariance, &derivative);
        }
        Self { matrix, covariance }
    }

    fn doubled(&self) -> Self {
        Self {
            matrix: product(&self.matrix, &self.matrix),
            covariance: self.of_covariance(&self.covariance),
        }
    }
}

/// `A P A^T`, symmetric to the last bit for a `P` that is.
fn congruence<const D: usize>(a: &Matrix<D>, p: &Matrix<D>) -> Matrix<D> {
    let half = product(a, p);
    let mut result = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..=i {
            let value = (0..D).map(|k| half[i][k] * a[j][k]).sum();
            result[i][j] = value;
            result[j][i] = value;
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_oscillator_ends_in_its_known_variances_and_an_undamped_one_nowhere() {
        // x'' + 2 xi w x' + w^2 x = W with E[W W] = delta: variances 1/(4 xi w^3) and 1/(4 xi w).
        let (w, xi) = (3.0, 0.02);
        let noise = [[0.0, 0.0], [0.0, 1.0]];
        let f = |xi: f64| [[0.0, 1.0], [-w * w, -2.0 * xi * w]];
        let p = Transition::stationary("oscillator", &f(xi), &noise).unwrap();
        assert!((p[0][0] * 4.0 * xi * w.powi(3) - 1.0).abs() < 1e-12, "{p:?}");
        assert!((p[1][1] * 4.0 * xi * w - 1.0).abs() < 1e-12 && p[0][1].abs() < 1e-12, "{p:?}");
        let error = Transition::stationary("oscillator", &f(0.0), &noise).unwrap_err();
        assert!(matches!(error, Error::NoStationaryLaw { .. }), "{error}");
    }

    #[test]
    fn the_law_over_a_time_is_that_over_its_parts() {
        let f = [[-0.3, 1.1, 0.0], [-2.0, -0.1, 0.4], [0.2, 0.0, -5.0]];
        let noise = [[0.1, 0.02, 0.0], [0.02, 0.5, 0.1], [0.0, 0.1, 0.3]];
        let (first, second) =
            (Transition::over(&f, &noise, 0.7), Transition::over(&f, &noise, 1.9));
        let whole = Transition::over(&f, &noise, 2.6);
        let parts = second.of_covariance(&first.covariance);
        for i in 0..3 {
            for j in 0..3 {
                assert!((whole.covariance[i][j] - parts[i][j]).abs() < 1e-14);
            }
        }
    }
}
