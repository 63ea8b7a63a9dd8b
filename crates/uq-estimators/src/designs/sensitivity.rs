//! Sobol' indices: which input causes how much of the variance.

use sde_integrators::{Estimate, Uncertainty};

use crate::comoments::Comoments;
use crate::designs::cube::UnitCube;
use crate::error::{Error, require_at_least};
use crate::ladder::Failure;
use crate::rates::{error_of_variance, jackknife};

/// Sobol' indices of one response, each with its standard error.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct SobolIndices {
    /// First-order index of each input: the part of the variance that it causes alone.
    pub first: Vec<Estimate>,
    /// Total index of each input: the part of the variance that remains if all others are fixed.
    pub total: Vec<Estimate>,
    /// Sum of the first-order indices: one for a response without interactions, less otherwise.
    pub first_sum: Estimate,
    /// Sum of the total indices: one for a response without interactions, more otherwise.
    pub total_sum: Estimate,
    /// Mean of the response.
    pub mean: Estimate,
    /// Variance of the response.
    pub variance: Estimate,
}

impl UnitCube {
    /// First-order and total Sobol' indices of each response.
    ///
    /// Each point has coordinates $a$ and $b$ for every input; the response is computed at $a$, at $b$, and for each input
    /// $i$ at $c_i$, which is $a$ with the coordinate $i$ of $b$: $n R (p + 2)$ runs for $p$ inputs. With means
    /// $\langle \cdot \rangle$ over the points,
    ///
    /// $$ S_i = \frac{\langle f_b f_{c_i} \rangle - m^2 - \rho_i (\langle f_a f_b \rangle - m_{ab}^2)}
    ///               {\tfrac12 \langle f_b^2 + f_{c_i}^2 \rangle - m^2}, \quad
    ///    m = \tfrac12 \langle f_b + f_{c_i} \rangle, \qquad
    ///    T_i = 1 - \rho_i = \frac{\tfrac12 \langle (f_a - f_{c_i})^2 \rangle}{\tfrac12 \langle f_a^2 + f_{c_i}^2 \rangle - m_i^2}, \quad
    ///    m_i = \tfrac12 \langle f_a + f_{c_i} \rangle . $$
    ///
    /// Responses at $a$ and $b$ are independent, so their covariance, about $m_{ab} = \tfrac12 \langle f_a + f_b \rangle$, is a
    /// control variate. Its coefficient is the correlation $\rho_i$ of $f_a$ and $f_{c_i}$. With $\rho_i = 1$ the index would be
    /// that of $f_b (f_{c_i} - f_a)$, sharp for small indices. With $\rho_i = 0$ it would be that of $f_b f_{c_i}$, sharp for large
    /// ones.
    ///
    /// Values are from the points of all replicas, errors from the delete-one jackknife over the replicas, with which the
    /// bias of the ratios is removed; of fewer than 64 points those of total indices and of the variance are as of
    /// a variance of [`ControlledSamples::raw`](crate::ControlledSamples::raw). An index near zero may have a negative estimate.
    ///
    /// Sources: Janon et al. 2014, Asymptotic normality and efficiency of two Sobol index estimators, eq 6 (first order,
    /// $\rho_i = 0$); Saltelli et al. 2010, Variance based sensitivity analysis of model output, table 2 (design; first order by the
    /// difference, $\rho_i = 1$); Jansen 1999, Analysis of variance designs for model output (total); Efron and Tibshirani 1993, An introduction to the
    /// bootstrap, chapter 11.
    ///
    /// ```
    /// use uq_estimators::{Sampling, UnitCube};
    ///
    /// // f = x_0 + 2 x_1: variances 1/12 and 4/12.
    /// let cube = UnitCube {
    ///     dimension: 2, sampling: Sampling::ScrambledSobol, seed: 1, n_points: 1 << 9, n_replicas: 16,
    /// };
    /// let sum = |x: &[f64], y: &mut [f64]| { y[0] = x[0] + 2.0 * x[1]; Ok(()) };
    /// let indices = &cube.sobol_indices(1, sum)?[0];
    /// assert!((indices.first[1].value - 0.8).abs() < 0.01 && (indices.total[1].value - 0.8).abs() < 0.01);
    /// # Ok::<(), uq_estimators::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`moments`](Self::moments), and [`Error::TooMany`] above 32 inputs of Sobol' points, which take two coordinates
    /// each; [`Error::NoVariance`] for a response that does not vary.
    pub fn sobol_indices(
        &self,
        n_responses: usize,
        response: impl Fn(&[f64], &mut [f64]) -> Result<(), Failure> + Sync + Send,
    ) -> Result<Vec<SobolIndices>, Error> {
        require_at_least("dimensions", self.dimension as u64, 1)?;
        let values = self.values(&self.index_runs()?, n_responses, response)?;
        let indices = |(response, values): (usize, &Vec<f64>)| self.indices(response, values);
        values.iter().enumerate().map(indices).collect()
    }
}

/// Indices from the sums of the replicas.
pub(crate) fn indices_of_sums(
    response: usize,
    p: usize,
    replicas: &[Comoments],
) -> Result<SobolIndices, Error> {
    let pooled = |without: Option<usize>| {
        let mut sums = Comoments::new(p + 2);
        for (k, replica) in replicas.iter().enumerate() {
            if Some(k) != without {
                sums.merge(replica);
            }
        }
        sums
    };
    let all = pooled(None);
    let value = all.variance(0);
    // Roundoff of the deviations, squared.
    let limit = (4.0 * f64::EPSILON * all.mean(0)).powi(2);
    if value.is_nan() || value <= limit {
        return Err(Error::NoVariance { response, value, limit });
    }
    let whole = quantities(&all, p);
    let left_out: Vec<Vec<f64>> =
        (0..replicas.len()).map(|k| quantities(&pooled(Some(k)), p)).collect();
    // Total indices and the variance are means of squares, of which few show a small scatter.
    let is_of_squares = |q: usize| (p..2 * p).contains(&q) || q == 2 * p + 3;
    let estimates: Vec<Estimate> = (0..whole.len())
        .map(|q| {
            let without: Vec<f64> = left_out.iter().map(|values| values[q]).collect();
            let mut found = jackknife(whole[q], &without);
            if let Uncertainty::StandardError(error) = &mut found.uncertainty
                && is_of_squares(q)
            {
                *error = error_of_variance(whole[q], *error, all.count());
            }
            found
        })
        .collect();
    Ok(SobolIndices {
        first: estimates[..p].to_vec(),
        total: estimates[p..2 * p].to_vec(),
        first_sum: estimates[2 * p],
        total_sum: estimates[2 * p + 1],
        mean: estimates[2 * p + 2],
        variance: estimates[2 * p + 3],
    })
}

/// First-order indices, total indices, both sums, mean and variance. Components: `f_a`, `f_b`, then `f_c` of each input.
fn quantities(sums: &Comoments, p: usize) -> Vec<f64> {
    let n = sums.count() as f64;
    let about_mean = |i: usize, j: usize| sums.covariance(i, j) * ((n - 1.0) / n);
    // Covariance and variance of two components about their common mean.
    let pair = |i: usize, j: usize| {
        let shift = 0.25 * (sums.mean(i) - sums.mean(j)).powi(2);
        let variance = 0.5 * (about_mean(i, i) + about_mean(j, j)) + shift;
        (about_mean(i, j) - shift, variance)
    };
    let mut found = Vec::with_capacity(2 * p + 4);
    let (independent, _) = pair(0, 1);
    for i in 0..p {
        let ((covariance, variance), (with_a, of_a)) = (pair(1, 2 + i), pair(0, 2 + i));
        found.push((covariance - with_a / of_a * independent) / variance);
    }
    for i in 0..p {
        let (covariance, variance) = pair(0, 2 + i);
        found.push((variance - covariance) / variance);
    }
    found.push(found[..p].iter().sum());
    found.push(found[p..2 * p].iter().sum());
    let (_, variance) = pair(0, 1);
    found.push(0.5 * (sums.mean(0) + sums.mean(1)));
    found.push(variance);
    found
}
