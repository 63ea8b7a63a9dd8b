//! Moments of a response over the unit cube, from replicas of points.

use crate::control::SampledMoments;
use crate::designed::DesignedRuns;
use crate::error::{Error, require_at_least, require_finite_responses};
use crate::ladder::Failure;
use crate::parallel::map_in_order;
use crate::points::Sampling;

/// Means and variances of responses of a point of the unit cube, by randomised quasi-Monte Carlo.
///
/// $$ \hat\mu = \frac1R \sum_r \hat\mu_r, \qquad \hat\mu_r = \frac1n \sum_{k < n} f(x_{rk}), \qquad
///    \text{s.e.}^2 = \frac{1}{R (R - 1)} \sum_r (\hat\mu_r - \hat\mu)^2 $$
///
/// The replicas are independent scrambles of the same points, each unbiased. The variance is the mean over the replicas of
/// $\hat\sigma_r^2 + R/(R-1)\, (\hat\mu_r - \hat\mu)^2$, with $\hat\sigma_r^2$ the mean square about $\hat\mu_r$: unbiased
/// too. A standard error from $R$ replicas has $R - 1$ degrees of freedom: for 8, 16, 32 replicas an interval of 95 % is
/// 2.36, 2.13, 2.04 standard errors to either side.
///
/// A random input with another distribution is the inverse of its distribution function of a coordinate; a probability is
/// the mean of an indicator.
///
/// Sources: L'Ecuyer and Lemieux 2002, Recent advances in randomized quasi-Monte Carlo methods; Owen 1997, Scrambled net
/// variance for integrals of smooth functions.
///
/// ```
/// use uq_estimators::{Sampling, UnitCube};
///
/// let cube = UnitCube {
///     dimension: 2, sampling: Sampling::ScrambledSobol, seed: 1, n_points: 1 << 10, n_replicas: 16,
/// };
/// let product = |x: &[f64], y: &mut [f64]| { y[0] = x[0] * x[1]; Ok(()) };
/// let mean = cube.moments(1, product)?[0].mean;
/// assert!((mean.value - 0.25).abs() < 1e-5 && mean.standard_error().unwrap() < 1e-5);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitCube {
    /// Number of coordinates; at most 64 of Sobol' points.
    pub dimension: usize,
    /// How the points are chosen.
    pub sampling: Sampling,
    /// Seed of the scrambles or points.
    pub seed: u64,
    /// Points of a replica; a power of two for Sobol' points.
    pub n_points: u64,
    /// Number of replicas, at least eight.
    pub n_replicas: u64,
}

/// Runs computed by one thread at a time.
const BLOCK: u64 = 64;

impl UnitCube {
    /// Mean and variance of each response.
    ///
    /// With the feature `rayon` runs are computed in parallel on the current pool; the result is bitwise identical for any number
    /// of threads.
    ///
    /// # Errors
    /// [`Error::TooFew`], [`Error::TooMany`], [`Error::NotPowerOfTwo`] for the fields; [`Error::SampleFailed`],
    /// [`Error::NonFiniteSample`] for the lowest run with such a response.
    pub fn moments(
        &self,
        n_responses: usize,
        response: impl Fn(&[f64], &mut [f64]) -> Result<(), Failure> + Sync + Send,
    ) -> Result<Vec<SampledMoments>, Error> {
        let values = self.values(&self.runs()?, n_responses, response)?;
        values.iter().map(|values| self.moments_of_runs(values, &[])).collect()
    }

    /// The values of each response in all runs of a design.
    pub(crate) fn values(
        &self,
        runs: &DesignedRuns,
        n_responses: usize,
        response: impl Fn(&[f64], &mut [f64]) -> Result<(), Failure> + Sync + Send,
    ) -> Result<Vec<Vec<f64>>, Error> {
        require_at_least("responses", n_responses as u64, 1)?;
        let n_runs = runs.n_runs();
        let blocks: Vec<u64> = (0..n_runs.div_ceil(BLOCK)).collect();
        let block = |&number: &u64| {
            let start = number * BLOCK;
            let (mut x, mut rows) = (vec![0.0; self.dimension], Vec::new());
            for run in start..n_runs.min(start + BLOCK) {
                runs.input(run, &mut x);
                let mut y = vec![0.0; n_responses];
                evaluate(&response, &x, run, &mut y)?;
                rows.append(&mut y);
            }
            Ok(rows)
        };
        let mut values = vec![Vec::new(); n_responses];
        for rows in map_in_order(&blocks, block) {
            for row in rows?.chunks_exact(n_responses) {
                values.iter_mut().zip(row).for_each(|(values, y)| values.push(*y));
            }
        }
        Ok(values)
    }
}

/// Responses of a point, checked.
fn evaluate(
    response: &impl Fn(&[f64], &mut [f64]) -> Result<(), Failure>,
    x: &[f64],
    run: u64,
    y: &mut [f64],
) -> Result<(), Error> {
    const MODEL: &str = "the response on the unit cube";
    response(x, y).map_err(|failure| Error::SampleFailed {
        model: MODEL.into(),
        realisation: run,
        message: failure.to_string(),
    })?;
    require_finite_responses(&MODEL, run, y)
}
