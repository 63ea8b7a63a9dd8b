//! Estimates with their errors.

use std::fmt;

use crate::error::Error;

/// A value with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its uncertainty.
    pub uncertainty: Uncertainty,
}

/// Uncertainty of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Uncertainty {
    /// Standard deviation of the estimate over repetitions of the study.
    StandardError(f64),
    /// Largest distance to the true value, certain or at a confidence stated by the source of the value.
    Bound(f64),
    /// Unknown: the user of the value must supply a reference.
    Unknown,
}

impl Estimate {
    /// Probability of an event with `hits` in `trials` independent trials.
    ///
    /// $$ \hat p = \frac kn, \qquad \text{s.e.} = \frac12 \left( \frac{m + 2 + 2 \sqrt{m (n - m)/n + 1}}{n + 4} - \frac mn \right), \qquad
    /// m = \min(k, n - k) $$
    ///
    /// This is half the distance to the farther end of Wilson's interval of two deviations; for many hits and misses it becomes
    /// `sqrt(p (1 - p)/n)`, which is far too small for a few hits: of one hit in 151 paths the truth was seven of those away.
    ///
    /// For zero hits, or only hits, the error is the [`Uncertainty::Bound`] `3/n`, the "rule of three": for `p` above it (below
    /// `1 - 3/n`), the probability of the outcome is below `exp(-3)`, 5 %.
    ///
    /// Sources: Wilson 1927, Probable inference, the law of succession, and statistical inference; Hanley and Lippman-Hand 1983, If
    /// nothing goes wrong, is everything all right?
    ///
    /// # Errors
    /// [`Error::TooFew`] for no trials, [`Error::TooMany`] for more hits than trials.
    pub fn probability(hits: u64, trials: u64) -> Result<Self, Error> {
        if trials == 0 {
            return Err(Error::TooFew { quantity: "trials", value: 0, limit: 1 });
        }
        let (k, n) = (hits as f64, trials as f64);
        if hits > trials {
            return Err(Error::TooMany { quantity: "hits", value: k, limit: n });
        }
        Self::share(k / n, n)
    }

    /// As [`probability`](Self::probability), of a share of values that are worth a number of independent trials, such as all values
    /// of some plates.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a share that is not from 0 to 1, or trials that are not positive.
    pub fn share(value: f64, trials: f64) -> Result<Self, Error> {
        if !(0.0..=1.0).contains(&value) {
            return Err(Error::NotPositive { quantity: "share, which is at most 1,", value });
        }
        if !(trials.is_finite() && trials > 0.0) {
            return Err(Error::NotPositive { quantity: "trials", value: trials });
        }
        let rare = value.min(1.0 - value);
        let uncertainty = if rare > 0.0 {
            let (m, n) = (rare * trials, trials);
            let end = (m + 2.0 + 2.0 * (m * (1.0 - rare) + 1.0).sqrt()) / (n + 4.0);
            Uncertainty::StandardError(0.5 * (end - rare))
        } else {
            Uncertainty::Bound((3.0 / trials).min(1.0))
        };
        Ok(Self { value, uncertainty })
    }

    /// The standard error, if that is the known uncertainty.
    #[must_use]
    pub const fn standard_error(&self) -> Option<f64> {
        match self.uncertainty {
            Uncertainty::StandardError(standard_error) => Some(standard_error),
            Uncertainty::Bound(_) | Uncertainty::Unknown => None,
        }
    }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.uncertainty {
            Uncertainty::StandardError(s) => write!(f, "{} +- {s:.2e} (s.e.)", self.value),
            Uncertainty::Bound(bound) => write!(f, "{} +- {bound:.2e} (bound)", self.value),
            Uncertainty::Unknown => write!(f, "{} (error unknown)", self.value),
        }
    }
}

/// Part of the sum of squared deviations that one value may hold before the error of the mean grows.
const SHARE_OF_ONE: f64 = 0.1;

/// Mean and variance of a sample, accumulated by values or by blocks.
///
/// Merging blocks in a fixed order is bitwise reproducible; see [`reduce_blocks`](crate::reduce_blocks).
///
/// Sources: Welford 1962, Note on a method for calculating corrected sums of squares and products; Chan, Golub and
/// LeVeque 1983, Algorithms for computing the sample variance, eq 2.1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Accumulator {
    count: u64,
    mean: f64,
    /// Sum of the squared deviations from the mean.
    squares: f64,
    /// The largest term of that sum, as values came.
    largest: f64,
}

impl Accumulator {
    /// Adds one value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let distance = value - self.mean;
        self.mean += distance / self.count as f64;
        let square = distance * (value - self.mean);
        self.squares += square;
        self.largest = self.largest.max(square);
    }

    /// Adds a later sample.
    pub fn merge(&mut self, later: &Self) {
        if later.count == 0 {
            return;
        }
        let (n_a, n_b) = (self.count as f64, later.count as f64);
        let n = n_a + n_b;
        let distance = later.mean - self.mean;
        self.count += later.count;
        self.mean += distance * (n_b / n);
        self.squares += later.squares + distance * distance * (n_a * (n_b / n));
        self.largest = self.largest.max(later.largest);
    }

    /// Number of values.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Mean of the sample; 0 if it is empty.
    #[must_use]
    pub const fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased variance of the sample.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than two values, [`Error::NonFiniteSample`] for values too large to be squared or summed.
    pub fn variance(&self) -> Result<f64, Error> {
        if self.count < 2 {
            return Err(Error::TooFew { quantity: "values", value: self.count, limit: 2 });
        }
        let (mean, variance) = (self.mean, self.squares / (self.count - 1) as f64);
        if mean.is_finite() && variance.is_finite() {
            Ok(variance)
        } else {
            Err(Error::NonFiniteSample { mean, variance })
        }
    }

    /// Mean of the sampled distribution, with its standard error.
    ///
    /// # Errors
    /// Those of [`variance`](Self::variance).
    pub fn estimate(&self) -> Result<Estimate, Error> {
        let standard_error = (self.variance()? / self.count as f64).sqrt();
        Ok(Estimate { value: self.mean, uncertainty: Uncertainty::StandardError(standard_error) })
    }

    /// As [`estimate`](Self::estimate), of a distribution whose tail may be heavy, such as a high power of a state.
    ///
    /// Where one value holds more than a tenth of the sum of squared deviations, rarer and larger ones decide on the mean, and the
    /// sample has none of them: the error then grows, and is unknown from `1/4 + 6/n` of the sum on.
    ///
    /// # Errors
    /// Those of [`variance`](Self::variance).
    pub fn cautious_estimate(&self) -> Result<Estimate, Error> {
        let (variance, n) = (self.variance()?, self.count as f64);
        let share = if self.squares > 0.0 { self.largest / self.squares } else { 0.0 };
        let most = 0.25 + 6.0 / n;
        let part = ((share - SHARE_OF_ONE) / (most - SHARE_OF_ONE)).clamp(0.0, 1.0);
        let error = (variance / n).sqrt() / (1.0 - part * part);
        let is_known = error.is_finite();
        let uncertainty =
            if is_known { Uncertainty::StandardError(error) } else { Uncertainty::Unknown };
        Ok(Estimate { value: self.mean, uncertainty })
    }
}
