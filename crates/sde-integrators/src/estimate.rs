//! Numbers with their errors.

use std::fmt;

use crate::error::Error;

/// A number and what is known of its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// What is known of its error.
    pub uncertainty: Uncertainty,
}

/// What is known of the error of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Uncertainty {
    /// One standard deviation of the estimate over repetitions of the whole study.
    StandardError(f64),
    /// The largest distance to the true value, certain or at a confidence that the source of the number states.
    Bound(f64),
    /// Nothing is known: whoever uses the number must bring a reference.
    Unknown,
}

impl Estimate {
    /// The probability of an event that happened in `hits` of `trials` independent trials.
    ///
    /// $$ \hat p = \frac kn, \qquad \text{s.e.} = \sqrt{\frac{\hat p (1 - \hat p)}{n}} $$
    ///
    /// If it happened never, or always, that formula would say that the error is zero. The error is then the
    /// [`Uncertainty::Bound`] `3/n`, the "rule of three": were `p` above it (below `1 - 3/n`), the outcome would have
    /// had a probability below `exp(-3)`, 5 %.
    ///
    /// Source: Hanley and Lippman-Hand 1983, If nothing goes wrong, is everything all right?
    ///
    /// # Errors
    /// [`Error::TooFew`] without a trial, [`Error::TooMany`] for more hits than trials.
    pub fn probability(hits: u64, trials: u64) -> Result<Self, Error> {
        if trials == 0 {
            return Err(Error::TooFew { quantity: "trials", value: 0, limit: 1 });
        }
        let (k, n) = (hits as f64, trials as f64);
        if hits > trials {
            return Err(Error::TooMany { quantity: "hits", value: k, limit: n });
        }
        let value = k / n;
        let uncertainty = if hits == 0 || hits == trials {
            Uncertainty::Bound((3.0 / n).min(1.0))
        } else {
            Uncertainty::StandardError((value * (1.0 - value) / n).sqrt())
        };
        Ok(Self { value, uncertainty })
    }

    /// The standard error, where that is what is known.
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

/// Mean and variance of a sample, taken in one value after the other or one block after the other.
///
/// Combining blocks in a fixed order gives the same bits whoever computed them; see
/// [`reduce_blocks`](crate::reduce_blocks).
///
/// Sources: Welford 1962, Note on a method for calculating corrected sums of squares and products; Chan, Golub and
/// LeVeque 1983, Algorithms for computing the sample variance, eq 2.1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Accumulator {
    count: u64,
    mean: f64,
    /// The sum of the squared distances to the mean.
    squares: f64,
}

impl Accumulator {
    /// Take in one value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let distance = value - self.mean;
        self.mean += distance / self.count as f64;
        self.squares += distance * (value - self.mean);
    }

    /// Take in the sample of another, which comes after this one.
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
    }

    /// How many values were taken in.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The mean of the sample; 0 where it is empty.
    #[must_use]
    pub const fn mean(&self) -> f64 {
        self.mean
    }

    /// The unbiased variance of the sample.
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

    /// The mean of the law the sample was drawn from, with its standard error.
    ///
    /// # Errors
    /// As [`variance`](Self::variance).
    pub fn estimate(&self) -> Result<Estimate, Error> {
        let standard_error = (self.variance()? / self.count as f64).sqrt();
        Ok(Estimate { value: self.mean, uncertainty: Uncertainty::StandardError(standard_error) })
    }
}

/// Means, variances and covariance of pairs `(y, c)`, for a control variate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ControlledAccumulator {
    values: Accumulator,
    controls: Accumulator,
    /// The sum of the products of the distances to the means.
    products: f64,
}

impl ControlledAccumulator {
    pub(crate) fn push(&mut self, value: f64, control: f64) {
        let distance = value - self.values.mean;
        self.values.push(value);
        self.controls.push(control);
        self.products += distance * (control - self.controls.mean);
    }

    pub(crate) fn merge(&mut self, later: &Self) {
        if later.values.count == 0 {
            return;
        }
        let (n_a, n_b) = (self.values.count as f64, later.values.count as f64);
        let distances =
            (later.values.mean - self.values.mean) * (later.controls.mean - self.controls.mean);
        self.products += later.products + distances * (n_a * (n_b / (n_a + n_b)));
        self.values.merge(&later.values);
        self.controls.merge(&later.controls);
    }

    /// How many pairs were taken in, if both of each were.
    pub(crate) fn count(&self) -> Option<u64> {
        (self.values.count == self.controls.count).then_some(self.values.count)
    }

    /// The mean of `y`, given that of `c`; the standard error is that of the residual of the regression on `c`.
    pub(crate) fn estimate(&self, expected: f64) -> Result<Estimate, Error> {
        let n = self.values.count;
        if n < 3 {
            return Err(Error::TooFew { quantity: "values with a control", value: n, limit: 3 });
        }
        let slope =
            if self.controls.squares > 0.0 { self.products / self.controls.squares } else { 0.0 };
        let residual = (self.values.squares - slope * self.products).max(0.0);
        let variance = residual / (n - 2) as f64;
        let value = self.values.mean - slope * (self.controls.mean - expected);
        if !(value.is_finite() && variance.is_finite()) {
            return Err(Error::NonFiniteSample { mean: value, variance });
        }
        let standard_error = (variance / n as f64).sqrt();
        Ok(Estimate { value, uncertainty: Uncertainty::StandardError(standard_error) })
    }
}
