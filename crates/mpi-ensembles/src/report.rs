//! What a job cost, block by block.

/// One block that was computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockReport {
    /// Its number.
    pub block: u64,
    /// The rank that computed it.
    pub rank: usize,
    /// How long it took by the clock (s).
    pub seconds: f64,
    /// Length of the message with its result; 0 on rank 0, which sends none.
    pub bytes: usize,
    /// How long rank 0 took to read the result, to keep it and to look at it (s): none other is taken in meanwhile.
    pub taking: f64,
}

/// What a job cost.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// How many ranks there were.
    pub n_ranks: usize,
    /// Blocks that were computed, in the order in which they came in.
    pub blocks: Vec<BlockReport>,
    /// Blocks that the store had from before.
    pub n_known: u64,
    /// From the start to the last block, by the clock of rank 0 (s).
    pub seconds: f64,
}

impl Report {
    /// Part of the time that ranks spent on blocks: `sum of block times / (n_ranks * time of the job)`. 1 where nobody ever waits; NaN for
    /// a job that took no time.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        let busy: f64 = self.blocks.iter().map(|block| block.seconds).sum();
        busy / (self.n_ranks as f64 * self.seconds)
    }
}
