//! What can be wrong with what a caller gives.

use thiserror::Error;

/// Why something could not be computed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// The output slice is not as long as the input slice.
    #[error("output slice has length {given}, the input slice {expected}")]
    LengthMismatch {
        /// Length of the output slice.
        given: usize,
        /// Length of the input slice, which the output must have.
        expected: usize,
    },
    /// A point has too little kernel around it for Shepard's correction.
    #[error("sum of volumes times kernel values is {value}, below {limit} or not finite")]
    ShepardSum {
        /// The sum given.
        value: f64,
        /// The smallest sum that is taken.
        limit: f64,
    },
    /// The neighbours of a point do not span its space, so no matrix makes slopes exact.
    #[error(
        "reciprocal condition {value} of the moment of kernel gradients is not at least {limit}"
    )]
    SingularMoment {
        /// Reciprocal condition of the moment; NaN when the moment holds one, zero when it has no inverse.
        value: f64,
        /// The smallest reciprocal condition that is taken.
        limit: f64,
    },
}
