//! The synthetic likelihood: a Gaussian with the mean and covariance of an ensemble.

use sde_integrators::{Estimate, Uncertainty};

use super::factor::{Factor, quadratic};
use super::gaussian::Observations;
use super::summaries::Summaries;
use crate::error::{Error, at_least};

/// Estimator of the log-likelihood from an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// The moments of the ensemble in place of the true ones (Wood 2010). Its bias is of order `1/n`: for one plate at the mean
    /// of the law and no error of measurement `(K^2 + K)/(4 n)` too high from the determinant, and too low by
    /// `(K^2 + 2 K)/(2 n)` from the distance.
    PlugIn,
    /// Less the bias to order `1/n` for normal summaries. What is left is of order `(K/n)^2`.
    BiasCorrected,
}

/// The likelihood of observed summaries at one value of the parameters, from an ensemble run at it:
///
/// $$ l = \sum_{p=1}^P \ln N(y_p; m, S + R) $$
///
/// `m`, `S`: mean and covariance of the summaries of the ensemble; `R`: variances of the errors of measurement; `y_p`: summaries of
/// plate `p`. It supposes that the summaries are nearly normal.
///
/// The standard error is that of the finite ensemble, by the infinitesimal jackknife: with the slopes `g` and `G` of `l` in `m` and
/// `S`, a realisation `x_k` moves `l` by `d_k/n`,
///
/// $$ d_k = g^T (x_k - m) + (x_k - m)^T G (x_k - m) - tr(G S), \quad s.e. = \sqrt{\sum_k d_k^2 / (n (n - 1))} . $$
///
/// It holds for summaries that are not normal as well; for few realisations it is a little too small.
///
/// Sources: Wood 2010, Statistical inference for noisy nonlinear ecological dynamic systems, Nature 466; Price, Drovandi, Lee and
/// Nott 2018, Bayesian synthetic likelihood (number of realisations, estimators); Efron 1982, The jackknife, the bootstrap and
/// other resampling plans, chapter 6. The unbiased estimator of the density of Ghurye and Olkin is not here: it is for one plate
/// without error of measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct SyntheticLikelihood {
    ensemble: Summaries,
    mean: Vec<f64>,
    covariance: Vec<f64>,
}

impl SyntheticLikelihood {
    /// From an ensemble.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than `K + 2` realisations, [`Error::NotPositiveDefinite`] where a summary is constant or
    /// follows from others.
    pub fn new(ensemble: Summaries) -> Result<Self, Error> {
        let k = ensemble.n_summaries();
        at_least("realisations with summaries", ensemble.n_realisations(), k + 2)?;
        let (mean, covariance) = ensemble.moments();
        Factor::new(k, &covariance)?;
        Ok(Self { ensemble, mean, covariance })
    }

    /// Mean of the summaries, `K`.
    #[must_use]
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Their unbiased covariance, `K` rows of `K`.
    #[must_use]
    pub fn covariance(&self) -> &[f64] {
        &self.covariance
    }

    /// The log-likelihood of all plates, with its standard error from the finite ensemble.
    ///
    /// # Errors
    /// [`Error::Count`] for plates with other summaries; [`Error::NotFinite`] for a plate too far away for numbers.
    pub fn log_likelihood(
        &self,
        data: &Observations,
        estimator: Estimator,
    ) -> Result<Estimate, Error> {
        let at = data.under(&self.mean, &self.covariance)?;
        let slopes = data.slopes(&at);
        let n = self.ensemble.n_realisations();
        let moved = |row: &[f64]| {
            let away: Vec<f64> = row.iter().zip(&self.mean).map(|(x, m)| x - m).collect();
            let by_mean: f64 = slopes.mean.iter().zip(&away).map(|(g, x)| g * x).sum();
            by_mean + quadratic(&slopes.covariance, &away)
        };
        let mut spread = sde_integrators::Accumulator::default();
        self.ensemble.rows().for_each(|row| spread.push(moved(row)));
        let standard_error = (spread.variance()? / n as f64).sqrt();
        let bias = match estimator {
            Estimator::PlugIn => 0.0,
            Estimator::BiasCorrected => data.bias(&at, &self.covariance, n),
        };
        let uncertainty = Uncertainty::StandardError(standard_error);
        Ok(Estimate { value: at.value - bias, uncertainty })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::super::summaries::Absent;
    use super::*;

    fn of(rows: &[Vec<f64>]) -> Result<SyntheticLikelihood, Error> {
        SyntheticLikelihood::new(Summaries::new(rows, Absent::default()).unwrap())
    }

    #[test]
    fn too_few_realisations_and_summaries_that_follow_from_others_are_refused() {
        let rows = |n: usize| -> Vec<Vec<f64>> {
            (0..n).map(|k| vec![(k as f64).sin(), (3.0 * k as f64).cos()]).collect()
        };
        assert!(of(&rows(4)).is_ok());
        let few = of(&rows(3));
        assert_eq!(
            few.unwrap_err().to_string(),
            "3 realisations with summaries; at least 4 are needed"
        );
        let twice: Vec<Vec<f64>> = rows(9).iter().map(|row| vec![row[0], 2.0 * row[0]]).collect();
        assert!(matches!(of(&twice), Err(Error::NotPositiveDefinite { row: 1, .. })));
        let constant: Vec<Vec<f64>> = rows(9).iter().map(|row| vec![row[0], 0.3]).collect();
        assert!(matches!(of(&constant), Err(Error::NotPositiveDefinite { row: 1, .. })));
    }

    #[test]
    fn standard_error_of_one_normal_summary_is_the_closed_form() {
        // Rows +-1 and 0 have m = 0 and s2 = 2/3 (n - 1 = 9 n/10 ... exact below); l = -(ln s2 + y^2/s2)/2 + const.
        let rows: Vec<Vec<f64>> = (0..30).map(|k| vec![f64::from(k % 3 - 1)]).collect();
        let found = of(&rows).unwrap();
        let plate = Summaries::new(&[vec![0.5]], Absent::default()).unwrap();
        let data = Observations::new(&plate, &[0.0]).unwrap();
        let estimate = found.log_likelihood(&data, Estimator::PlugIn).unwrap();
        let s2 = 20.0 / 29.0;
        // d = g x + G x^2 - G s2 with g = y/s2, G = (y^2/s2^2 - 1/s2)/2, for x of -1, 0, 1 ten times each.
        let (g, curvature) = (0.5 / s2, 0.5 * (0.25 / (s2 * s2) - 1.0 / s2));
        let moves = [curvature - g, 0.0, curvature + g];
        let centre = moves.iter().sum::<f64>() / 3.0;
        let squares: f64 = moves.iter().map(|d| 10.0 * (d - centre) * (d - centre)).sum();
        let expected = (squares / 29.0 / 30.0).sqrt();
        assert!((estimate.standard_error().unwrap() - expected).abs() < 1e-14);
    }
}
