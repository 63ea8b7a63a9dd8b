//! What is wrong with a parameter, with the value and its limit.

/// Errors of declaring a system.
#[derive(Debug, thiserror::Error)]
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
    /// A parameter must be greater than another.
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
    /// A table has too few rows.
    #[error("{name} has {count} rows; at least {limit} are needed")]
    TooFewRows {
        /// The table.
        name: &'static str,
        /// How many were given.
        count: usize,
        /// How many are needed.
        limit: usize,
    },
    /// The rows of a table do not increase.
    #[error("{name}: row {row} is at {value}; it must be greater than the row before it, {limit}")]
    NotIncreasing {
        /// The table.
        name: &'static str,
        /// The first row, from 0, that is not greater than the one before it.
        row: usize,
        /// Its value.
        value: f64,
        /// The value of the row before it.
        limit: f64,
    },
    /// A linear system has no stationary distribution: not all of its modes decay.
    #[error(
        "{name} has no stationary law: after a time of {time:e} its transition is still {value:e}, above {limit:e}"
    )]
    NoStationaryLaw {
        /// The system.
        name: &'static str,
        /// How long was waited.
        time: f64,
        /// The largest entry of the transition matrix then.
        value: f64,
        /// What it had to fall below.
        limit: f64,
    },
    /// The initial distribution was refused.
    #[error(transparent)]
    Sde(#[from] sde_integrators::Error),
}

/// Refuses NaN and infinity.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { name, value }) }
}

/// Refuses what is not finite and greater than zero.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    finite(name, value)?;
    if value > 0.0 { Ok(()) } else { Err(Error::NotPositive { name, value }) }
}

/// Refuses what is not finite and at least zero.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), Error> {
    finite(name, value)?;
    if value >= 0.0 { Ok(()) } else { Err(Error::Negative { name, value }) }
}

/// Refuses what is not from `from` to `to`.
pub(crate) fn within(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    finite(name, value)?;
    if (from..=to).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange { name, value, from, to })
    }
}
