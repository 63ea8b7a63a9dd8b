//! Errors of invalid input.

use thiserror::Error;

/// Error of a computation.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// Output and input slice differ in length.
    #[error("output slice has length {given}, the input slice {expected}")]
    LengthMismatch {
        /// Length of the output slice.
        given: usize,
        /// Length of the input slice, which the output must have.
        expected: usize,
    },
    /// Too little of the kernel is covered by neighbours for Shepard's correction.
    #[error("sum of volumes times kernel values is {value}, below {limit} or not finite")]
    ShepardSum {
        /// The sum given.
        value: f64,
        /// Smallest admissible sum.
        limit: f64,
    },
    /// The neighbours of a point do not span the space, so no matrix makes gradients exact.
    #[error(
        "reciprocal condition {value} of the moment of kernel gradients is not at least {limit}"
    )]
    SingularMoment {
        /// Reciprocal condition of the moment; NaN if the moment contains NaN, zero if it is singular.
        value: f64,
        /// Smallest admissible reciprocal condition.
        limit: f64,
    },
}
