//! Samples that are kept: quantiles and probabilities of what was seen of each path.

use crate::error::Error;
use crate::estimate::{Estimate, Uncertainty};

/// A sample, in ascending order, all of it kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    sorted: Vec<f64>,
}

impl Samples {
    /// The least expected number of values on either side of a quantile.
    pub const LEAST_BESIDE: u64 = 10;

    /// Sort a sample.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than two values, [`Error::NotFinite`] for one that is not.
    pub fn new(mut values: Vec<f64>) -> Result<Self, Error> {
        let n = values.len() as u64;
        if n < 2 {
            return Err(Error::TooFew { quantity: "values", value: n, limit: 2 });
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let value = values[index];
            return Err(Error::NotFinite { quantity: "value", index, value });
        }
        values.sort_unstable_by(f64::total_cmp);
        Ok(Self { sorted: values })
    }

    /// The values, ascending.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.sorted
    }

    /// The probability to lie above a level, with the error of [`Estimate::probability`].
    ///
    /// # Errors
    /// None that can occur: there are at least two values.
    pub fn exceedance(&self, level: f64) -> Result<Estimate, Error> {
        let n = self.sorted.len();
        let above = n - self.sorted.partition_point(|&value| value <= level);
        Estimate::probability(above as u64, n as u64)
    }

    /// The quantile of a probability: the value of rank `ceil(n p)`.
    ///
    /// How many values lie below the true quantile is binomial, with the deviation `sqrt(n p (1 - p))`; half the distance
    /// between the values that many ranks below and above is the standard error. No density is needed for it.
    /// Source: David and Nagaraja 2003, Order statistics, section 7.1.
    ///
    /// # Errors
    /// [`Error::TooFew`] where fewer than [`LEAST_BESIDE`](Self::LEAST_BESIDE) values are expected below or above, so also
    /// for a probability outside `(0, 1)`.
    pub fn quantile(&self, probability: f64) -> Result<Estimate, Error> {
        let n = self.sorted.len();
        let expected = n as f64 * probability.min(1.0 - probability);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to n; a NaN becomes 0"
        )]
        let whole = |x: f64| x.max(0.0) as usize;
        if expected.is_nan() || expected < Self::LEAST_BESIDE as f64 {
            return Err(Error::TooFew {
                quantity: "values beside a quantile",
                value: whole(expected) as u64,
                limit: Self::LEAST_BESIDE,
            });
        }
        let rank = n as f64 * probability;
        let deviation = (rank * (1.0 - probability)).sqrt();
        let at = |rank: f64| self.sorted[whole(rank.ceil() - 1.0).min(n - 1)];
        let standard_error = 0.5 * (at(rank + deviation) - at(rank - deviation));
        let uncertainty = Uncertainty::StandardError(standard_error);
        Ok(Estimate { value: at(rank), uncertainty })
    }
}
