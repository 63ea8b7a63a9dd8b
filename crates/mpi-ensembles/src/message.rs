//! Messages between ranks.

use serde::{Deserialize, Serialize};

use crate::error::JobError;

/// A message.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Message {
    /// To rank 0: ready for the first block of the job that these fields identify.
    Ready { n_blocks: u64, identity: Vec<(String, String)> },
    /// To rank 0: result of a block and its computing time.
    Done { block: u64, part: Vec<u8>, seconds: f64 },
    /// To rank 0: a block failed.
    Failed { block: u64, message: String },
    /// From rank 0: a block to compute.
    Compute { block: u64 },
    /// From rank 0: no block is left.
    End,
    /// From rank 0: this rank belongs to another job.
    Foreign { field: String, found: String, expected: String },
}

impl Message {
    pub(crate) fn to_bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(self)
    }

    /// # Errors
    /// [`JobError::Message`].
    pub(crate) fn of(rank: usize, bytes: &[u8]) -> Result<Self, JobError> {
        postcard::from_bytes(bytes).map_err(|source| JobError::Message { rank, source })
    }

    /// Error for a message of an unexpected kind.
    pub(crate) fn out_of_turn(&self, rank: usize, expected: &'static str) -> JobError {
        JobError::OutOfTurn { rank, found: self.name(), expected }
    }

    const fn name(&self) -> &'static str {
        match self {
            Self::Ready { .. } => "`ready`",
            Self::Done { .. } => "a result",
            Self::Failed { .. } => "a failure",
            Self::Compute { .. } => "a block to compute",
            Self::End => "`end`",
            Self::Foreign { .. } => "a refusal",
        }
    }
}
