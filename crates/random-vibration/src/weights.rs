//! Weighted samples of an event, and whether their standard error can be trusted.

use sde_integrators::{Accumulator, Estimate};

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
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Contributions {
    values: Accumulator,
    squares: Accumulator,
    largest: f64,
    hits: u64,
}

impl Contributions {
    /// Adds a path: its contribution if it reached the event, otherwise `None`.
    pub(crate) fn push(&mut self, contribution: Option<f64>) {
        let value = contribution.unwrap_or(0.0);
        self.values.push(value);
        self.squares.push(value * value);
        self.largest = self.largest.max(value);
        self.hits += u64::from(contribution.is_some());
    }

    pub(crate) fn merge(&mut self, later: &Self) {
        self.values.merge(&later.values);
        self.squares.merge(&later.squares);
        self.largest = self.largest.max(later.largest);
        self.hits += later.hits;
    }

    pub(crate) const fn hits(&self) -> u64 {
        self.hits
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
        let estimate = self.values.estimate()?;
        let n = self.values.count() as f64;
        let sum = n * self.values.mean();
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
