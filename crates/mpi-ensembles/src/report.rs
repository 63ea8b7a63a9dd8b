//! Cost of a job, block by block.

/// Cost of one computed block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockReport {
    /// Number of the block.
    pub block: u64,
    /// The rank that computed it.
    pub rank: usize,
    /// Elapsed time (s).
    pub seconds: f64,
    /// Length of the message with its result; 0 on rank 0, which sends no message.
    pub bytes: usize,
    /// Time that rank 0 spends reading, storing and inspecting the result (s); it processes no other result meanwhile.
    pub taking: f64,
}

/// Cost of a job.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Number of ranks.
    pub n_ranks: usize,
    /// Computed blocks, in the order of arrival.
    pub blocks: Vec<BlockReport>,
    /// Number of blocks that the store already held.
    pub n_known: u64,
    /// Elapsed time on rank 0 from the start to the last block (s).
    pub seconds: f64,
}

impl Report {
    /// Fraction of time that ranks spend on blocks: `sum of block times / (n_ranks * time of the job)`.
    ///
    /// It is 1 if no rank ever waits, and NaN for a job that took no time.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        let busy: f64 = self.blocks.iter().map(|block| block.seconds).sum();
        busy / (self.n_ranks as f64 * self.seconds)
    }
}
