//! Run options.

use std::path::PathBuf;
use std::time::Duration;

use super::part::EnsemblePart;
use crate::checkpoint::Start;

/// Options of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Folder of the results.
    pub out: PathBuf,
    /// Replaces the seed of the scene.
    pub seed: Option<u64>,
    /// Whether to start from the beginning, resume, or overwrite.
    pub start: Start,
    /// Minimum interval between two checkpoints.
    pub checkpoint_every: Duration,
    /// The whole ensemble, a shard of it, or the merge of shards.
    pub part: EnsemblePart,
    /// A part of the run that would take longer, by what its first ten seconds have done, is refused; no limit if none. On ranks it
    /// does not count.
    pub longest: Option<Duration>,
}

impl Options {
    /// Default minimum interval between two checkpoints.
    pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(10);

    /// A run from the beginning with the seed of the scene, however long it takes.
    pub fn new(out: impl Into<PathBuf>) -> Self {
        let (seed, start) = (None, Start::Anew);
        let (checkpoint_every, part) = (Self::CHECKPOINT_EVERY, EnsemblePart::Whole);
        Self { out: out.into(), seed, start, checkpoint_every, part, longest: None }
    }
}
