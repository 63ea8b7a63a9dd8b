//! How a scene is run.

use std::path::PathBuf;
use std::time::Duration;

use super::part::Part;
use crate::checkpoint::Start;

/// How a scene is run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Where the results go.
    pub out: PathBuf,
    /// In place of the seed of the scene.
    pub seed: Option<u64>,
    /// From nothing or from a checkpoint; whether over one.
    pub start: Start,
    /// The least time between two checkpoints.
    pub checkpoint_every: Duration,
    /// All of an ensemble, a shard of it, or what shards have come to.
    pub part: Part,
}

impl Options {
    /// The least time between two checkpoints, where nothing else is asked for.
    pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(10);

    /// A run from nothing, with the seed of the scene.
    pub fn new(out: impl Into<PathBuf>) -> Self {
        let (seed, start) = (None, Start::Anew);
        let (checkpoint_every, part) = (Self::CHECKPOINT_EVERY, Part::Whole);
        Self { out: out.into(), seed, start, checkpoint_every, part }
    }
}
