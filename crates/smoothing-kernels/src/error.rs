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
    /// A kernel has no support.
    #[error("the support of the kernel is {value}; it must be positive and finite")]
    KernelSupport {
        /// The support, in smoothing lengths.
        value: f64,
    },
    /// A kernel does not keep a law that the solvers rely on.
    #[error(
        "in {dimension} dimensions {law} is {value} at q = {q}; it must be {expected} within {limit:e}"
    )]
    KernelLaw {
        /// What is looked at.
        law: &'static str,
        /// Number of dimensions.
        dimension: usize,
        /// Distance in smoothing lengths; of an integral the support.
        q: f64,
        /// What the kernel gives.
        value: f64,
        /// What it must be.
        expected: f64,
        /// Largest admissible difference.
        limit: f64,
    },
}
