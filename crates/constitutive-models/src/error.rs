//! Errors of parameters and of updates, with the value and its limit.

use perturbation_moments::Real;

/// A parameter outside its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is NaN or infinite.
    #[error("{name} is {value}; it must be finite")]
    NotFinite {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter must be greater than zero.
    #[error("{name} is {value}; it must be greater than 0")]
    NotPositive {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter must not be negative.
    #[error("{name} is {value}; it must be 0 or greater")]
    Negative {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter lies outside an interval.
    #[error("{name} is {value}; it must be from {from} to {to}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The least that is allowed.
        from: f64,
        /// The most that is allowed.
        to: f64,
    },
    /// Two parameters must be in ascending order.
    #[error("{name} is {value}; it must be greater than {other}, which is {limit}")]
    OutOfOrder {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The parameter it must exceed.
        other: &'static str,
        /// The value of that one.
        limit: f64,
    },
}

/// What a material cannot do.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{quantity} is {value}; it must be {must}")]
pub struct Fault {
    /// What left its range.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// What it must be, in words.
    pub must: &'static str,
}

impl Fault {
    /// Refuses a value where a mask is false; of several lanes it names the first.
    ///
    /// # Errors
    /// The fault.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
    pub fn unless<S: Real>(
        holds: S::Mask,
        value: S,
        quantity: &'static str,
        must: &'static str,
    ) -> Result<(), Self> {
        match value.first_outside(holds) {
            None => Ok(()),
            Some(value) => Err(Self { quantity, value, must }),
        }
    }
}

/// Refuses what is not finite.
///
/// # Errors
/// [`Error`] with name, value and limit.
pub fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { name, value }) }
}

/// Refuses what is not finite and above zero.
///
/// # Errors
/// [`Error`] with name, value and limit.
pub fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    finite(name, value)?;
    if value > 0.0 { Ok(()) } else { Err(Error::NotPositive { name, value }) }
}

/// Refuses what is not finite or below zero.
///
/// # Errors
/// [`Error`] with name, value and limit.
pub fn not_negative(name: &'static str, value: f64) -> Result<(), Error> {
    finite(name, value)?;
    if value >= 0.0 { Ok(()) } else { Err(Error::Negative { name, value }) }
}

/// Refuses what lies outside an interval.
///
/// # Errors
/// [`Error`] with name, value and limit.
pub fn within(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    finite(name, value)?;
    if (from..=to).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange { name, value, from, to })
    }
}
