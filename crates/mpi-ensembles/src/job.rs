//! A job: the blocks of an ensemble, and their results.

use crate::report::Report;

/// The blocks of an ensemble.
///
/// How many there are is decided by the ensemble alone, never by the number of ranks: then the parts are the same whoever computes them, and
/// what is made of them in their order has the same bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// Blocks `0..n_blocks`.
    pub n_blocks: u64,
    /// What tells this ensemble from others, by name: version, scene, seed. A rank that differs is refused by the name of the
    /// first that does.
    pub identity: Vec<(String, String)>,
}

/// What rank 0 has at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished<T> {
    /// The result of each block, in the order of the blocks.
    pub parts: Vec<T>,
    /// What it cost.
    pub report: Report,
}
