//! Stored samples: quantiles and exceedance probabilities.

use crate::error::Error;
use crate::estimate::{Estimate, Uncertainty};

/// A complete sample in ascending order.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    sorted: Vec<f64>,
}

impl Samples {
    /// Smallest expected number of values on either side of a quantile.
    pub const LEAST_BESIDE: u64 = 10;

    /// Sorts a sample.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than two values, [`Error::NotFinite`] for a value that is not finite.
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

    /// The values in ascending order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.sorted
    }

    /// Probability of exceeding a level, with the error of [`Estimate::probability`].
    ///
    /// # Errors
    /// None in practice: there are at least two values.
    pub fn exceedance(&self, level: f64) -> Result<Estimate, Error> {
        let n = self.sorted.len();
        let above = n - self.sorted.partition_point(|&value| value <= level);
        Estimate::probability(above as u64, n as u64)
    }

    /// The quantile of a probability: the value of rank `ceil(n p)`.
    ///
    /// The number of values below the true quantile is binomial, with the deviation `sqrt(n p (1 - p))`. Half the
    /// distance between the values that many ranks below and above is the standard error. No density estimate is
    /// required.
    /// Source: David and Nagaraja 2003, Order statistics, section 7.1.
    ///
    /// # Errors
    /// [`Error::TooFew`] if fewer than [`LEAST_BESIDE`](Self::LEAST_BESIDE) values are expected below or above, which
    /// includes a probability outside `(0, 1)`.
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
