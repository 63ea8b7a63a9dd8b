//! A request to end a run at its next checkpoint.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Whether the runs of this process are to end at their next checkpoint.
#[must_use]
pub fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Asks the runs of this process to write a checkpoint as soon as they can and to end with
/// [`CheckpointError::Interrupted`](crate::checkpoint::CheckpointError::Interrupted); the command does so when a signal comes.
/// Between two checkpoints lie a time of observation, a saved step, or a block of realisations.
///
/// Returns whether they had been asked before.
pub fn request() -> bool {
    REQUESTED.swap(true, Ordering::Relaxed)
}
