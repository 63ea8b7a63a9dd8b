//! Why a job did not come to its end.

/// Ranks that do not reach one another.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The other end is gone.
    #[error("rank {rank} is gone")]
    Gone {
        /// The rank that was spoken to; that of the listener where all others are gone.
        rank: usize,
    },
    /// MPI was started before, or has been ended.
    #[error("MPI cannot be started: it was started before in this process")]
    Started,
    /// The library of MPI does not let one thread of several call it.
    #[error("this MPI allows threads to the level {found} only; Funneled is needed")]
    Threads {
        /// The level it has.
        found: String,
    },
}

/// Why a job has no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// A job without blocks has no result.
    #[error("the number of blocks is 0; it must be at least 1")]
    NoBlocks,
    /// A block could not be computed: it failed or panicked.
    #[error("rank {rank} failed in block {block}: {message}")]
    Block {
        /// The rank that computed it.
        rank: usize,
        /// Its number.
        block: u64,
        /// What it said.
        message: String,
    },
    /// A rank that was started with another program or other inputs.
    #[error("rank {rank} is of another job: its {field} is {found}, that of rank 0 is {expected}")]
    ForeignRank {
        /// Which.
        rank: usize,
        /// What differs.
        field: String,
        /// What it has.
        found: String,
        /// What rank 0 has.
        expected: String,
    },
    /// A block that was kept could not be read, or a new one could not be kept.
    #[error("block {block} could not be {what}")]
    Store {
        /// Which.
        block: u64,
        /// `read` or `kept`.
        what: &'static str,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A message that no rank of this version sends.
    #[error("a message from rank {rank} cannot be read")]
    Message {
        /// Who sent it.
        rank: usize,
        /// Why.
        source: postcard::Error,
    },
    /// A part of the result that has no form in bytes.
    #[error("the result of block {block} has no form in bytes")]
    Encode {
        /// Which.
        block: u64,
        /// Why.
        source: postcard::Error,
    },
    /// A message that does not belong where it came.
    #[error("rank {rank} sent {found} where {expected} was due")]
    OutOfTurn {
        /// Who sent it.
        rank: usize,
        /// What came.
        found: &'static str,
        /// What should have.
        expected: &'static str,
    },
    /// Ranks that do not reach one another.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The thread that computes on rank 0 could not be started.
    #[error("the thread of rank 0 that computes could not be started")]
    Thread(#[source] std::io::Error),
}
