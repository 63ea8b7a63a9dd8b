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
}
