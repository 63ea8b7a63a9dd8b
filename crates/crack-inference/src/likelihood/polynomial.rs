//! Quadratic polynomials through numbers at the points of a design.

use crate::error::{Error, at_least};
use crate::factor::{Factor, quadratic};

/// Points of a design beyond the terms of the polynomial: what the lack of fit is seen by.
const LEAST_SPARE: usize = 4;

/// Weighted least squares by
///
/// $$ b(x) = (1, x_i, x_i x_j)_{i \le j}, \qquad f(x) = \sum_j h_j(x) f_j, \qquad
///    h(x) = b(x)^T (B^T W B)^{-1} B^T W, $$
///
/// one set of weights `h` for all numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Polynomial {
    n_terms: usize,
    /// `(B^T W B)^-1 B^T W`, point after point.
    solution: Vec<f64>,
}

/// `b(x)`.
pub(crate) fn terms(units: &[f64]) -> Vec<f64> {
    let mut terms = vec![1.0];
    terms.extend(units);
    for i in 0..units.len() {
        terms.extend(units[i..].iter().map(|x| units[i] * x));
    }
    terms
}

impl Polynomial {
    /// From the places of a design in units and a weight for each.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than 4 points more than terms, [`Error::NotPositiveDefinite`] where points do not determine the
    /// terms, as on a line.
    pub(crate) fn new(design: &[Vec<f64>], weights: &[f64]) -> Result<Self, Error> {
        let dimension = design.first().map_or(0, Vec::len);
        let n_terms = (dimension + 1) * (dimension + 2) / 2;
        at_least("points of the design", design.len(), n_terms + LEAST_SPARE)?;
        let mut normal = vec![0.0; n_terms * n_terms];
        let rows: Vec<Vec<f64>> = design.iter().map(|units| terms(units)).collect();
        for (row, weight) in rows.iter().zip(weights) {
            for i in 0..n_terms {
                for j in 0..n_terms {
                    normal[i * n_terms + j] += weight * row[i] * row[j];
                }
            }
        }
        let factor = Factor::new(n_terms, &normal)?;
        let mut solution = vec![];
        for (row, weight) in rows.iter().zip(weights) {
            let mut column: Vec<f64> = row.iter().map(|b| weight * b).collect();
            factor.solve(&mut column);
            solution.append(&mut column);
        }
        Ok(Self { n_terms, solution })
    }

    /// Coefficients of the polynomial through numbers, one for each point.
    pub(crate) fn coefficients(&self, numbers: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.n_terms];
        for (number, column) in numbers.zip(self.solution.chunks_exact(self.n_terms)) {
            for (coefficient, entry) in coefficients.iter_mut().zip(column) {
                *coefficient += number * entry;
            }
        }
        coefficients
    }

    /// `h(x)`.
    pub(crate) fn shares(&self, units: &[f64]) -> Vec<f64> {
        let terms = terms(units);
        self.solution.chunks_exact(self.n_terms).map(|column| dot(&terms, column)).collect()
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `sum_j h_j^2 s^T C_j s`: the variance of what moves by `s` with the numbers of each point.
pub(crate) fn variance<'a>(
    shares: &[f64],
    slopes: &[f64],
    covariances: impl Iterator<Item = &'a [f64]>,
) -> f64 {
    shares.iter().zip(covariances).map(|(h, c)| h * h * quadratic(c, slopes)).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

    fn design() -> Vec<Vec<f64>> {
        (0..14).map(|k| vec![f64::from(k % 4) / 2.0 - 0.8, (f64::from(k) * 0.7).sin()]).collect()
    }

    #[test]
    fn quadratic_is_found_whatever_the_weights() {
        let truth = |x: &[f64]| {
            1.0 + 2.0 * x[0] - x[1] + 0.5 * x[0] * x[0] + 3.0 * x[0] * x[1] - 2.0 * x[1] * x[1]
        };
        let weights: Vec<f64> = (1..=14).map(f64::from).collect();
        let polynomial = Polynomial::new(&design(), &weights).unwrap();
        let numbers: Vec<f64> = design().iter().map(|x| truth(x)).collect();
        let coefficients = polynomial.coefficients(numbers.iter().copied());
        for (found, expected) in coefficients.iter().zip([1.0, 2.0, -1.0, 0.5, 3.0, -2.0]) {
            assert!((found - expected).abs() < 1e-12, "{coefficients:?}");
        }
        let at = [0.3, -0.4];
        let by_shares = dot(&polynomial.shares(&at), &numbers);
        assert!((by_shares - truth(&at)).abs() < 1e-12);
    }

    #[test]
    fn designs_that_do_not_tell_the_terms_apart_are_refused() {
        let few = Polynomial::new(&design()[..9], &[1.0; 9]);
        assert!(matches!(few, Err(Error::TooFew { value: 9, limit: 10, .. })));
        let line: Vec<Vec<f64>> = (0..14).map(|k| vec![0.1 * f64::from(k); 2]).collect();
        let line = Polynomial::new(&line, &[1.0; 14]);
        assert!(matches!(line, Err(Error::NotPositiveDefinite { .. })));
    }
}
