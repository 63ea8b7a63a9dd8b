//! First passage from the rates of crossing: an upper bound, and the expected number of crossings.

use crate::error::{Error, finite, not_negative};

/// The expected number of crossings into failure up to a time, and with it an upper bound of the probability of first
/// passage (Rice 1944; Shinozuka 1964):
///
/// $$ P\left( \max_{s \le t} y(s) > T \right) \le P(y(0) > T) + \int_0^t \nu^+(T, s) ds . $$
///
/// The bound is close where crossings are rare and come singly; an oscillator in a narrow band crosses in clumps, and the
/// bound is then high by the mean number of crossings in a clump. The integral is taken by the trapezoidal rule over the
/// times recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutcrossingBound {
    initial: f64,
    crossings: f64,
    last: Option<(f64, f64)>,
}

impl OutcrossingBound {
    /// Starts from `P(y(0) > T)`.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Negative`] for the probability.
    pub fn new(initial_probability: f64) -> Result<Self, Error> {
        not_negative("initial probability", initial_probability)?;
        Ok(Self { initial: initial_probability, crossings: 0.0, last: None })
    }

    /// Adds the rate of crossing at a time, no earlier than the one before.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Negative`] for the rate, [`Error::TimeInThePast`].
    pub fn record(&mut self, time: f64, rate: f64) -> Result<(), Error> {
        finite("time", time)?;
        not_negative("crossing rate", rate)?;
        if let Some((before, rate_before)) = self.last {
            if time < before {
                return Err(Error::TimeInThePast { value: time, now: before });
            }
            self.crossings += 0.5 * (time - before) * (rate + rate_before);
        }
        self.last = Some((time, rate));
        Ok(())
    }

    /// `int nu^+ ds` over the times recorded: the expected number of crossings.
    pub fn expected_crossings(&self) -> f64 {
        self.crossings
    }

    /// The upper bound of the probability of first passage; at most 1, which bounds any probability.
    pub fn probability(&self) -> f64 {
        (self.initial + self.crossings).min(1.0)
    }
}
