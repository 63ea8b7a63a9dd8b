//! A job: the blocks of an ensemble and their results.

use crate::report::Report;

/// The blocks of an ensemble.
///
/// The number of blocks depends on the ensemble alone, never on the number of ranks. The results are then the same
/// whichever rank computes them, and statistics formed in block order are bitwise identical.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// Blocks `0..n_blocks`.
    pub n_blocks: u64,
    /// Named fields that identify this ensemble: version, scene, seed.
    ///
    /// A rank with another identity is rejected with the name of the first field that differs.
    pub identity: Vec<(String, String)>,
}

/// Result of a job on rank 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished<T> {
    /// The result of each block, in the order of the blocks.
    pub parts: Vec<T>,
    /// Timings of the job.
    pub report: Report,
}
