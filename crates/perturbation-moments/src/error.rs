//! Errors, with the value and its limit.

/// Error of a random vector, an expansion or a moment.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A quantity is not finite.
    #[error("{quantity} {index} is {value}, must be finite")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its index; entries of a matrix or a tensor are counted row by row.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A quantity is not finite or not positive.
    #[error("{quantity} is {value}, must be finite and positive")]
    NotPositive {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A standard deviation or variance is negative.
    #[error("{quantity} {index} is {value}, must not be negative")]
    Negative {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A matrix is not symmetric.
    #[error(
        "{matrix} differs by {difference:e} between ({row}, {column}) and ({column}, {row}), the limit is {limit:e}"
    )]
    NotSymmetric {
        /// Name of the matrix.
        matrix: &'static str,
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// Difference between the two entries.
        difference: f64,
        /// Largest admissible difference.
        limit: f64,
    },
    /// A diagonal entry of a correlation is not one, or another entry exceeds one.
    #[error("correlation ({row}, {column}) is {value}, {requirement}")]
    Correlation {
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// Its value.
        value: f64,
        /// Requirement for the entry.
        requirement: &'static str,
    },
    /// The correlation is impossible for a random vector.
    #[error(
        "the correlation of the normal coordinates has the eigenvalue {eigenvalue:e} (number {index} from the smallest), must be at least {limit:e}"
    )]
    NotPositiveSemidefinite {
        /// Index of the eigenvalue, from the smallest.
        index: usize,
        /// The eigenvalue.
        eigenvalue: f64,
        /// Smallest value explained by roundoff.
        limit: f64,
    },
    /// A lognormal input has a mean that is not positive.
    #[error("lognormal input {index} has mean {value}, must be above zero")]
    LognormalMean {
        /// Index of the input.
        index: usize,
        /// Its mean.
        value: f64,
    },
    /// The first-order variance is zero, so corrections have no scale and importance factors are undefined.
    #[error(
        "the first-order variance is {value:e}, must exceed {limit:e}: the response is flat where it is expanded"
    )]
    NoFirstOrderVariance {
        /// The variance.
        value: f64,
        /// Its roundoff, which it must exceed.
        limit: f64,
    },
    /// A moment requires second derivatives that are missing.
    #[error("{moment} needs {needed}, {given} given")]
    CurvatureIncomplete {
        /// Name of the moment.
        moment: &'static str,
        /// Required derivatives.
        needed: &'static str,
        /// Available derivatives.
        given: &'static str,
    },
    /// A moment requires third derivatives that are missing.
    #[error("{moment} needs third derivatives, none given")]
    ThirdDerivativesMissing {
        /// Name of the moment.
        moment: &'static str,
    },
    /// A number of items is below its minimum.
    #[error("{value} {quantity}, at least {limit} needed")]
    TooFew {
        /// Kind of items.
        quantity: &'static str,
        /// Number given.
        value: u64,
        /// Minimum.
        limit: u64,
    },
    /// The response of a sample is not finite.
    #[error("response of sample {realisation} is {value}, must be finite")]
    NonFiniteSample {
        /// Lowest sample that failed.
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
