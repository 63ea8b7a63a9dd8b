//! Errors of a job and of its transport.

/// Communication error between ranks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The other rank has exited.
    #[error("rank {rank} has exited")]
    Gone {
        /// The rank addressed; the receiving rank itself where all others have exited.
        rank: usize,
    },
    /// MPI was started before in this process, or has been finalised.
    #[error("MPI cannot be started: it was started before in this process")]
    Started,
    /// The MPI library does not allow calls from one thread of several.
    #[error("the MPI library supports the thread level {found}; at least Funneled is required")]
    Threads {
        /// Thread level that it supports.
        found: String,
    },
}

/// Error of a job.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// The job has no blocks.
    #[error("the number of blocks is 0; it must be at least 1")]
    NoBlocks,
    /// A block failed or panicked.
    #[error("rank {rank} failed in block {block}: {message}")]
    Block {
        /// The rank that computed it.
        rank: usize,
        /// Number of the block.
        block: u64,
        /// Error text or panic message.
        message: String,
    },
    /// A rank was started with another program or other inputs.
    #[error(
        "rank {rank} belongs to another job: its {field} is {found}, that of rank 0 is {expected}"
    )]
    ForeignRank {
        /// The rank.
        rank: usize,
        /// Name of the field that differs.
        field: String,
        /// Its value on that rank.
        found: String,
        /// Its value on rank 0.
        expected: String,
    },
    /// A stored block could not be read, or a new one could not be stored.
    #[error("block {block} could not be {what}")]
    Store {
        /// Number of the block.
        block: u64,
        /// `read` or `kept`.
        what: &'static str,
        /// Error of the store.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A message has an unknown format.
    #[error("a message from rank {rank} cannot be decoded: start all ranks with the same program")]
    Message {
        /// The sender.
        rank: usize,
        /// Error of the decoder.
        source: postcard::Error,
    },
    /// A result cannot be serialised.
    #[error("the result of block {block} cannot be serialised")]
    Encode {
        /// Number of the block.
        block: u64,
        /// Error of the encoder.
        source: postcard::Error,
    },
    /// A message was not expected in this state.
    #[error("rank {rank} sent {found}; expected was {expected}")]
    OutOfTurn {
        /// The sender.
        rank: usize,
        /// Kind of message received.
        found: &'static str,
        /// Kind of message expected.
        expected: &'static str,
    },
    /// Communication between ranks failed.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The computing thread of rank 0 could not be started.
    #[error("the computing thread of rank 0 could not be started")]
    Thread(#[source] std::io::Error),
}
