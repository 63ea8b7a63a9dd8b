//! The Cholesky factor of a small covariance.
//!
//! Likelihoods factor ten by ten numbers many thousand times, where the call to a library for large matrices costs more than the
//! work; and a covariance that is singular but for roundoff must be refused, which a plain factorisation does not do.

use crate::error::Error;

/// What must be left of the variance of a number, given those before it: below it, it is a function of them.
const LEAST_REST: f64 = 1e-12;

/// The lower triangle `L` with `A = L L^T`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Factor {
    n: usize,
    /// Row after row, each of `n` entries.
    l: Vec<f64>,
}

impl Factor {
    /// Reads the lower triangle of `n` rows of `a`.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`] for a pivot below 1e-12 of its diagonal entry.
    pub(crate) fn new(n: usize, a: &[f64]) -> Result<Self, Error> {
        let mut l = vec![0.0; n * n];
        for row in 0..n {
            for column in 0..=row {
                let known: f64 = (0..column).map(|k| l[row * n + k] * l[column * n + k]).sum();
                let rest = a[row * n + column] - known;
                l[row * n + column] = if row == column {
                    let limit = LEAST_REST * a[row * n + row].abs();
                    if rest.is_nan() || rest <= limit {
                        return Err(Error::NotPositiveDefinite { row, limit });
                    }
                    rest.sqrt()
                } else {
                    rest / l[column * n + column]
                };
            }
        }
        Ok(Self { n, l })
    }

    /// `L_ij`.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.l[i * self.n + j]
    }

    /// `ln |A|`.
    pub(crate) fn log_determinant(&self) -> f64 {
        (0..self.n).map(|i| 2.0 * simd_lanes::ln(self.at(i, i))).sum()
    }

    /// `L z` into `out`.
    pub(crate) fn apply(&self, z: &[f64], out: &mut [f64]) {
        for i in 0..self.n {
            out[i] = (0..=i).map(|j| self.at(i, j) * z[j]).sum();
        }
    }

    /// `L^-1 b` in its place.
    pub(crate) fn solve_lower(&self, b: &mut [f64]) {
        for i in 0..self.n {
            let known: f64 = (0..i).map(|j| self.at(i, j) * b[j]).sum();
            b[i] = (b[i] - known) / self.at(i, i);
        }
    }

    /// `L^-T b` in its place, for the leading block of as many rows as `b` has numbers.
    pub(crate) fn solve_upper(&self, b: &mut [f64]) {
        for i in (0..b.len()).rev() {
            let known: f64 = (i + 1..b.len()).map(|j| self.at(j, i) * b[j]).sum();
            b[i] = (b[i] - known) / self.at(i, i);
        }
    }

    /// `A^-1 b` in its place.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        self.solve_lower(b);
        self.solve_upper(b);
    }

    /// `A^-1`, row after row.
    pub(crate) fn inverse(&self) -> Vec<f64> {
        let n = self.n;
        let mut inverse = vec![0.0; n * n];
        for i in 0..n {
            let column = &mut inverse[i * n..(i + 1) * n];
            column[i] = 1.0;
            self.solve(column);
        }
        inverse
    }
}

/// `A B` of square matrices, row after row.
pub(crate) fn product(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut c = vec![0.0; n * n];
    for i in 0..n {
        for k in 0..n {
            for j in 0..n {
                c[i * n + j] += a[i * n + k] * b[k * n + j];
            }
        }
    }
    c
}

/// `tr(A B)` of symmetric matrices.
pub(crate) fn trace_of_product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `x^T A x`.
pub(crate) fn quadratic(a: &[f64], x: &[f64]) -> f64 {
    let rows = a.chunks_exact(x.len()).zip(x);
    rows.map(|(row, x_i)| x_i * row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

    const A: [f64; 9] = [4.0, 2.0, 0.4, 2.0, 5.0, -1.0, 0.4, -1.0, 3.0];

    #[test]
    fn inverse_and_determinant_are_those_of_the_matrix() {
        let factor = Factor::new(3, &A).unwrap();
        let unit = product(3, &A, &factor.inverse());
        for i in 0..9 {
            let expected = if i % 4 == 0 { 1.0 } else { 0.0 };
            assert!((unit[i] - expected).abs() < 1e-15 * 10.0, "{unit:?}");
        }
        // 4 (15 - 1) - 2 (6 + 0.4) + 0.4 (-2 - 2) = 41.6.
        assert!((factor.log_determinant() - 41.6_f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn number_that_follows_from_others_is_refused_with_its_row() {
        // The third is the sum of the other two, but for roundoff.
        let (a, b, c) = (1.0, 0.3, 2.0);
        let singular = [a, b, a + b, b, c, b + c, a + b, b + c, a + 2.0 * b + c + 1e-15];
        let refused = Factor::new(3, &singular);
        assert!(matches!(refused, Err(Error::NotPositiveDefinite { row: 2, .. })), "{refused:?}");
        let nan = Factor::new(1, &[f64::NAN]);
        assert!(matches!(nan, Err(Error::NotPositiveDefinite { row: 0, .. })));
    }
}
