//! The Gaussian log-density of observed plates, with its slopes in mean and covariance.

use std::f64::consts::PI;

use crate::error::{Error, finite, same_count};
use crate::factor::{Factor, product, quadratic, trace_of_product};
use crate::summaries::Summaries;

/// The summaries of plates that were observed, independent of each other, and the variances of the errors of measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    n_plates: f64,
    mean: Vec<f64>,
    /// About the mean, over the number of plates.
    scatter: Vec<f64>,
    error_variances: Vec<f64>,
}

impl Observations {
    /// From one row for each plate; `error_variances` has one number for each summary (its unit squared), zero where it is
    /// measured without error. Errors are normal and independent of each other.
    ///
    /// # Errors
    /// [`Error::Count`]; [`Error::NotFinite`], [`Error::NotPositive`] for a variance below zero.
    pub fn new(plates: &Summaries, error_variances: &[f64]) -> Result<Self, Error> {
        same_count("variances of errors", error_variances.len(), plates.n_summaries())?;
        for &value in error_variances {
            finite("the variance of an error", value)?;
            if value < 0.0 {
                return Err(Error::NotPositive { name: "the variance of an error", value });
            }
        }
        let n = plates.n_realisations() as f64;
        let (mean, covariance) = plates.moments();
        // One plate has no scatter, and no unbiased covariance.
        let share = (n - 1.0) / n;
        let scatter = covariance.iter().map(|c| if n > 1.0 { share * c } else { 0.0 }).collect();
        Ok(Self { n_plates: n, mean, scatter, error_variances: error_variances.to_vec() })
    }

    /// How many summaries a plate has, `K`.
    #[must_use]
    pub fn n_summaries(&self) -> usize {
        self.mean.len()
    }

    /// How many plates there are, `P`.
    #[must_use]
    pub fn n_plates(&self) -> usize {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "it was a usize"
        )]
        let n = self.n_plates as usize;
        n
    }

    /// The log-density of all plates under a mean and a covariance `S`:
    ///
    /// $$ l = -\frac P2 \left( K \ln 2\pi + \ln |A| + tr(A^{-1} W) \right), \quad A = S + R, \quad
    ///    W = V + (\bar y - m)(\bar y - m)^T $$
    ///
    /// with mean and scatter `V` of the plates and the diagonal `R` of the variances of errors.
    pub(crate) fn under(&self, mean: &[f64], covariance: &[f64]) -> Result<At, Error> {
        let k = self.n_summaries();
        same_count("the mean of the summaries", mean.len(), k)?;
        let mut with_error = covariance.to_vec();
        for i in 0..k {
            with_error[i * k + i] += self.error_variances[i];
        }
        let factor = Factor::new(k, &with_error)?;
        let away: Vec<f64> = (0..k).map(|i| self.mean[i] - mean[i]).collect();
        let inverse = factor.inverse();
        let distance = trace_of_product(&inverse, &self.scatter) + quadratic(&inverse, &away);
        let constant = k as f64 * simd_lanes::ln(2.0 * PI);
        let value = -0.5 * self.n_plates * (constant + factor.log_determinant() + distance);
        finite("the log-likelihood", value)?;
        Ok(At { value, inverse, away })
    }

    /// Slopes of the log-density in mean and covariance,
    ///
    /// $$ g = P A^{-1} (\bar y - m), \qquad G = \frac P2 (A^{-1} W A^{-1} - A^{-1}). $$
    pub(crate) fn slopes(&self, at: &At) -> Slopes {
        let k = self.n_summaries();
        let mut scatter = self.scatter.clone();
        for i in 0..k {
            for j in 0..k {
                scatter[i * k + j] += at.away[i] * at.away[j];
            }
        }
        let b = &at.inverse;
        let mut covariance = product(k, &product(k, b, &scatter), b);
        for (g, b) in covariance.iter_mut().zip(b) {
            *g = 0.5 * self.n_plates * (*g - b);
        }
        let row = |i: usize| (0..k).map(|j| b[i * k + j] * at.away[j]).sum::<f64>();
        let mean = (0..k).map(|i| self.n_plates * row(i)).collect();
        Slopes { mean, covariance }
    }
}

/// A log-density and what its slopes are made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct At {
    pub(crate) value: f64,
    inverse: Vec<f64>,
    away: Vec<f64>,
}

/// Slopes of a log-density.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slopes {
    /// In the mean, `K`.
    pub(crate) mean: Vec<f64>,
    /// In the covariance, `K` rows of `K`; `tr(G dS)` is the change.
    pub(crate) covariance: Vec<f64>,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;
    use crate::summaries::Absent;

    fn data(errors: [f64; 2]) -> Observations {
        let rows = [vec![1.0, 2.0], vec![0.5, -1.0], vec![2.0, 0.3]];
        Observations::new(&Summaries::new(&rows, Absent::default()).unwrap(), &errors).unwrap()
    }

    #[test]
    fn log_density_of_independent_numbers_is_the_sum_of_theirs() {
        let (mean, variances) = ([0.7, 0.1], [1.5, 2.0]);
        let found = data([0.5, 0.0]).under(&mean, &[1.0, 0.0, 0.0, 2.0]).unwrap().value;
        let mut expected = 0.0;
        for plate in [[1.0, 2.0], [0.5, -1.0], [2.0, 0.3]] {
            for i in 0..2 {
                let distance: f64 = plate[i] - mean[i];
                expected -=
                    0.5 * (distance * distance / variances[i] + (2.0 * PI * variances[i]).ln());
            }
        }
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    }

    #[test]
    fn slopes_are_those_of_differences() {
        let data = data([0.2, 0.1]);
        let (mean, covariance) = ([0.4, 0.2], [1.2, 0.3, 0.3, 0.8]);
        let slopes = data.slopes(&data.under(&mean, &covariance).unwrap());
        let h = 1e-5;
        // Central differences: h^2 times third derivatives of order 10.
        for i in 0..2 {
            let value = |step: f64| {
                let mut mean = mean;
                mean[i] += step;
                data.under(&mean, &covariance).unwrap().value
            };
            let slope = (value(h) - value(-h)) / (2.0 * h);
            assert!((slope - slopes.mean[i]).abs() < 1e-7, "{slope} {:?}", slopes.mean);
        }
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let value = |step: f64| {
                let mut covariance = covariance;
                covariance[i * 2 + j] += step;
                covariance[j * 2 + i] = covariance[i * 2 + j];
                data.under(&mean, &covariance).unwrap().value
            };
            let slope = (value(h) - value(-h)) / (2.0 * h);
            let both = if i == j { 1.0 } else { 2.0 };
            assert!((slope - both * slopes.covariance[i * 2 + j]).abs() < 1e-7);
        }
    }

    #[test]
    fn one_plate_has_no_scatter_and_errors_below_zero_are_refused() {
        let one = Summaries::new(&[vec![3.0]], Absent::default()).unwrap();
        let data = Observations::new(&one, &[0.0]).unwrap();
        assert_eq!(data.n_plates(), 1);
        let found = data.under(&[1.0], &[4.0]).unwrap().value;
        assert!((found + 0.5 * ((8.0 * PI).ln() + 1.0)).abs() < 1e-14);
        assert!(matches!(Observations::new(&one, &[-1.0]), Err(Error::NotPositive { .. })));
        assert!(matches!(Observations::new(&one, &[]), Err(Error::Count { .. })));
    }
}
