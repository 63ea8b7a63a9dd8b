//! What can go wrong, with the value and its limit.

/// Why a random vector, an expansion or a moment could not be had.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A quantity is infinite or not a number.
    #[error("{quantity} {index} is {value}, must be finite")]
    NotFinite {
        /// Which one.
        quantity: &'static str,
        /// Its place among its like; entries of a matrix or a tensor count row by row.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A quantity is infinite, not a number, or not above zero.
    #[error("{quantity} is {value}, must be finite and positive")]
    NotPositive {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A standard deviation or variance is below zero.
    #[error("{quantity} {index} is {value}, must not be negative")]
    Negative {
        /// Which one.
        quantity: &'static str,
        /// Its place.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A matrix is not symmetric.
    #[error(
        "{matrix} differs by {difference:e} between ({row}, {column}) and ({column}, {row}), the limit is {limit:e}"
    )]
    NotSymmetric {
        /// Which matrix.
        matrix: &'static str,
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// By how much the two entries differ.
        difference: f64,
        /// By how much they may differ.
        limit: f64,
    },
    /// A correlation with itself is not one, or one with another is beyond one.
    #[error("correlation ({row}, {column}) is {value}, {requirement}")]
    Correlation {
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// No random vector has this correlation.
    #[error(
        "the correlation of the normal coordinates has the eigenvalue {eigenvalue:e} (number {index} from the smallest), must be at least {limit:e}"
    )]
    NotPositiveSemidefinite {
        /// Which eigenvalue, counted from the smallest.
        index: usize,
        /// The eigenvalue.
        eigenvalue: f64,
        /// The smallest that roundoff excuses.
        limit: f64,
    },
    /// A lognormal input has a mean that is not above zero.
    #[error("lognormal input {index} has mean {value}, must be above zero")]
    LognormalMean {
        /// Which input.
        index: usize,
        /// Its mean.
        value: f64,
    },
    /// The first-order variance is zero: nothing to compare a correction with, and no importance factors.
    #[error(
        "the first-order variance is {value:e}, must exceed {limit:e}: the response is flat where it is expanded"
    )]
    NoFirstOrderVariance {
        /// What was found.
        value: f64,
        /// What it must exceed: its own roundoff.
        limit: f64,
    },
    /// A moment needs second derivatives that were not given.
    #[error("{moment} needs {needed}, {given} given")]
    CurvatureIncomplete {
        /// Which moment.
        moment: &'static str,
        /// What it needs.
        needed: &'static str,
        /// What there is.
        given: &'static str,
    },
    /// A moment needs third derivatives that were not given.
    #[error("{moment} needs third derivatives, none given")]
    ThirdDerivativesMissing {
        /// Which moment.
        moment: &'static str,
    },
    /// Differences do not settle: the response is not smooth on their scale, or too noisy.
    #[error(
        "derivative by {inputs:?} from differences has error {error:e}, the limit is {limit:e} (both over the first-order deviation)"
    )]
    DifferencesUnsettled {
        /// By which inputs, as many as the order.
        inputs: [Option<usize>; 3],
        /// The estimated error, of the derivative times its inputs' deviations.
        error: f64,
        /// The largest that is taken.
        limit: f64,
    },
    /// There are fewer of something than its least number.
    #[error("{value} {quantity}, at least {limit} needed")]
    TooFew {
        /// Of what.
        quantity: &'static str,
        /// How many there are.
        value: u64,
        /// How many there must be.
        limit: u64,
    },
    /// The response of a sample is not finite.
    #[error("response of sample {realisation} is {value}, must be finite")]
    NonFiniteSample {
        /// The lowest sample that failed.
        realisation: u64,
        /// Its response.
        value: f64,
    },
}

pub(crate) fn require_finite(
    quantity: &'static str,
    index: usize,
    value: f64,
) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { quantity, index, value }) }
}

pub(crate) fn require_positive(quantity: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::NotPositive { quantity, value })
    }
}
