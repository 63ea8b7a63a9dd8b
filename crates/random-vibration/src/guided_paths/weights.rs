//! Weighted samples of an event, and whether their standard error can be trusted.

use sde_integrators::{Accumulator, Estimate, Uncertainty};

use crate::tail::TailError;

/// Smallest effective sample size: below it the standard error is itself known to no better than a tenth.
const FEWEST: f64 = 50.0;
/// Largest share of one weight: above it one path decides on the result, and its absence would not have been noticed.
const LARGEST_SHARE: f64 = 0.05;

/// A probability from guided paths, with the figures that say how far its standard error can be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct GuidedEstimate {
    /// The probability with its standard error.
    pub estimate: Estimate,
    /// Number of paths, without pilots.
    pub n_paths: u64,
    /// Number of paths that reached the event.
    pub n_hits: u64,
    /// `(sum w)^2 / sum w^2` over the paths that reached the event (no unit).
    pub effective_sample_size: f64,
    /// Largest weight over the sum of all weights (no unit).
    pub largest_share: f64,
    /// Factor on the running deviations in the linearisation, chosen by the pilot paths (no unit).
    pub strength: f64,
}

/// Sums of the contributions of paths to one mean.
///
/// Successive paths of a block have the same guide, or the next one: their squared differences estimate the variance within
/// the strata of the guides, from above. For independent paths `E (w_(k+1) - w_k)^2 / 2` is the variance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Contributions {
    values: Accumulator,
    squares: Accumulator,
    /// `(w_(k+1) - w_k)^2` within blocks.
    differences: Accumulator,
    /// The last contribution, of a block that is not finished.
    last: Option<f64>,
    largest: f64,
    hits: u64,
}

impl Contributions {
    /// Adds a path: its contribution if it reached the event, otherwise `None`.
    pub(crate) fn push(&mut self, contribution: Option<f64>) {
        let value = contribution.unwrap_or(0.0);
        self.values.push(value);
        self.squares.push(value * value);
        if let Some(last) = self.last {
            self.differences.push((value - last) * (value - last));
        }
        self.last = Some(value);
        self.largest = self.largest.max(value);
        self.hits += u64::from(contribution.is_some());
    }

    /// Adds the sums of a later block.
    pub(crate) fn merge(&mut self, later: &Self) {
        self.values.merge(&later.values);
        self.squares.merge(&later.squares);
        self.differences.merge(&later.differences);
        self.last = None;
        self.largest = self.largest.max(later.largest);
        self.hits += later.hits;
    }

    /// Whether the counts are possible for a block of this many paths.
    pub(crate) const fn is_of(&self, n_paths: u64) -> bool {
        let (values, squares) = (self.values.count(), self.squares.count());
        let differences = self.differences.count();
        values == n_paths
            && squares == n_paths
            && differences == n_paths.saturating_sub(1)
            && self.hits <= n_paths
    }

    pub(crate) const fn hits(&self) -> u64 {
        self.hits
    }

    /// Number of paths.
    pub(crate) const fn count(&self) -> u64 {
        self.values.count()
    }

    pub(crate) const fn mean(&self) -> f64 {
        self.values.mean()
    }

    /// The estimate of the mean.
    ///
    /// # Errors
    /// [`TailError::Untrusted`] for an effective sample size or a largest share beyond its limit;
    /// [`TailError::Sampling`] for fewer than two paths.
    pub(crate) fn estimate(
        &self,
        threshold: f64,
        strength: f64,
    ) -> Result<GuidedEstimate, TailError> {
        let (mean, n) = (self.values.mean(), self.values.count() as f64);
        // Weights of a common event may add up to more than one.
        let value = mean.min(1.0);
        // Refuses fewer than two paths and values that are not finite.
        self.values.variance()?;
        let variance = 0.5 * self.differences.mean() / n;
        let uncertainty = Uncertainty::StandardError(variance.sqrt());
        let estimate = Estimate { value, uncertainty };
        let sum = n * mean;
        let square = n * self.squares.mean();
        let of_sum = |numerator: f64, sum: f64| if sum > 0.0 { numerator / sum } else { 0.0 };
        let (effective, share) = (of_sum(sum * sum, square), of_sum(self.largest, sum));
        if !(effective >= FEWEST && share <= LARGEST_SHARE) {
            return Err(TailError::Untrusted {
                threshold,
                n_paths: self.values.count(),
                hits: self.hits,
                effective,
                fewest: FEWEST,
                share,
                most: LARGEST_SHARE,
            });
        }
        Ok(GuidedEstimate {
            estimate,
            n_paths: self.values.count(),
            n_hits: self.hits,
            effective_sample_size: effective,
            largest_share: share,
            strength,
        })
    }
}

/// Joins the sums of two neighbouring blocks, sum by sum.
pub(crate) fn merge_sums(
    mut earlier: Vec<Contributions>,
    later: Vec<Contributions>,
) -> Vec<Contributions> {
    for (sum, more) in earlier.iter_mut().zip(later) {
        sum.merge(&more);
    }
    earlier
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Contributions {
        let mut sums = Contributions::default();
        for value in values {
            sums.push((*value > 0.0).then_some(*value));
        }
        sums
    }

    #[test]
    fn the_error_is_that_within_strata() {
        // Two guides with different weights, one after the other: the step between them counts once.
        let (low, high) = ([1.0, 1.2, 1.0, 1.2], [5.0, 5.2, 5.0, 5.2]);
        let strata = of(&[low, high].concat());
        let found = |sums: &Contributions| sums.differences.mean();
        assert!((found(&strata) - (6.0 * 0.04 + 3.8 * 3.8) / 7.0).abs() < 1e-12);
        // Blocks are apart: no difference from one to the next.
        let mut blocks = of(&low);
        blocks.merge(&of(&high));
        assert!((found(&blocks) - 0.04).abs() < 1e-12 && blocks.count() == 8);
        let estimate = merged(200, &low).estimate(1.0, 2.0).unwrap().estimate;
        let exact = (0.5 * 0.04 / 800.0_f64).sqrt();
        assert!((estimate.standard_error().unwrap() / exact - 1.0).abs() < 1e-9, "{estimate}");
    }

    /// Sums of some blocks.
    fn merged(n: usize, block: &[f64]) -> Contributions {
        let mut sums = Contributions::default();
        for _ in 0..n {
            sums.merge(&of(block));
        }
        sums
    }

    #[test]
    fn even_weights_count_fully_and_one_heavy_weight_is_refused() {
        let even = of(&[0.5; 100]).estimate(1.0, 2.0).unwrap();
        assert!((even.effective_sample_size - 100.0).abs() < 1e-9, "{even:?}");
        assert!((even.largest_share - 0.01).abs() < 1e-12 && even.n_hits == 100, "{even:?}");
        let mut heavy = vec![0.5; 100];
        heavy[7] = 4.0;
        let refused = of(&heavy).estimate(1.0, 2.0).unwrap_err();
        assert!(matches!(refused, TailError::Untrusted { hits: 100, share, .. } if share > 0.05));
        for none in [of(&[0.0; 100]), of(&[1e-200; 100])] {
            let refused = none.estimate(1.0, 2.0).unwrap_err();
            assert!(matches!(refused, TailError::Untrusted { effective: 0.0, .. }), "{refused}");
        }
    }
}
