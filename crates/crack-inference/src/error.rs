//! What can go wrong, with the value and its limit.

/// Why something could not be inferred.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number is NaN or infinite.
    #[error("{name} is {value}; it must be finite")]
    NotFinite {
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
    },
    /// A number must be greater than zero.
    #[error("{name} is {value}; it must be greater than 0 and finite")]
    NotPositive {
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
    },
    /// A number lies outside an open interval.
    #[error("{name} is {value}; it must lie between {from} and {to}")]
    OutOfRange {
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
        /// Below what is allowed.
        from: f64,
        /// Above what is allowed.
        to: f64,
    },
    /// Fewer of something than are needed.
    #[error("{value} {name}; at least {limit} are needed")]
    TooFew {
        /// Name of the counted things.
        name: &'static str,
        /// How many.
        value: usize,
        /// How many are needed.
        limit: usize,
    },
    /// A list of another length than those it goes with.
    #[error("{value} numbers in {name}; there must be {expected}")]
    Count {
        /// Which list.
        name: &'static str,
        /// How many there are.
        value: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A matrix that must be positive definite and is not.
    #[error("the matrix is not positive definite: the pivot of row {row} is not above {limit:e}")]
    NotPositiveDefinite {
        /// The row where the factorisation failed.
        row: usize,
        /// What the pivot must exceed: roundoff.
        limit: f64,
    },
    /// Bounds of a parameter that hold nothing, or what it cannot be.
    #[error("the bounds of {name} are {low} and {high}; {must}")]
    Bounds {
        /// The parameter.
        name: String,
        /// The lower one.
        low: f64,
        /// The upper one.
        high: f64,
        /// What they must be.
        must: &'static str,
    },
    /// A value of a parameter beyond its bounds.
    #[error("{name} is {value}; its bounds are {low} and {high}")]
    OutOfBounds {
        /// The parameter.
        name: String,
        /// What was given.
        value: f64,
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
    },
    /// One of the ensembles of an emulator.
    #[error("ensemble {ensemble}: {reason}")]
    Ensemble {
        /// Which, from 0 on.
        ensemble: usize,
        /// Why it does not do.
        reason: Box<Error>,
    },
    /// An estimate could not be made.
    #[error(transparent)]
    Estimate(#[from] sde_integrators::Error),
    /// A covariance of errors could not be factored.
    #[error(transparent)]
    Covariance(#[from] random_fields::Error),
}

pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { name, value }) }
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(Error::NotPositive { name, value }) }
}

pub(crate) fn between(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    if value > from && value < to {
        Ok(())
    } else {
        Err(Error::OutOfRange { name, value, from, to })
    }
}

pub(crate) fn at_least(name: &'static str, value: usize, limit: usize) -> Result<(), Error> {
    if value < limit { Err(Error::TooFew { name, value, limit }) } else { Ok(()) }
}

pub(crate) fn same_count(name: &'static str, value: usize, expected: usize) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(Error::Count { name, value, expected }) }
}
