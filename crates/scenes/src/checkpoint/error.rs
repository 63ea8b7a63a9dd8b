//! Why a checkpoint is not taken.

use std::path::PathBuf;

/// A checkpoint that could not be read or written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum CheckpointError {
    /// There are files, and none can be gone on from.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    #[diagnostic(help(
        "--overwrite starts from the beginning; shards are joined by the scene that made them"
    ))]
    Refused(Vec<Refusal>),
    /// A run would start anew over one that has not come to its end.
    #[error("{} is of a run that has not come to its end", .path.display())]
    #[diagnostic(help(
        "--resume goes on from it, --overwrite starts from the beginning over it, another --out leaves it alone"
    ))]
    Unfinished {
        /// The last checkpoint.
        path: PathBuf,
    },
    /// A part that is not what its name says.
    #[error("the part `{name}` of the checkpoint")]
    Part {
        /// Which.
        name: String,
        /// What is wrong with it.
        source: postcard::Error,
    },
    /// The system refused.
    #[error("cannot read or write the checkpoint {}", .path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// A file that is not gone on from.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} {reason}", .path.display())]
pub struct Refusal {
    /// Which file.
    pub path: PathBuf,
    /// Why.
    pub reason: Reason,
}

/// Why a file is not gone on from.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// It does not begin as one.
    #[error("is no checkpoint")]
    NoCheckpoint,
    /// It ends too soon, or too late.
    #[error("is cut off: {found} bytes of {expected}")]
    CutOff {
        /// Its length (bytes).
        found: u64,
        /// What its head says (bytes).
        expected: u64,
    },
    /// Its hash is not that of its bytes.
    #[error("is damaged: its bytes have the hash {found:016x}, written was {expected:016x}")]
    Damaged {
        /// Of the bytes.
        found: u64,
        /// At its end.
        expected: u64,
    },
    /// A file that the scene names had other bytes.
    #[error("was made with another {file}: its bytes had the hash {found}, now it is {expected}")]
    OtherFile {
        /// Its path, as the scene has it.
        file: String,
        /// XXH64 of what the run was made with.
        found: String,
        /// Of what is there now.
        expected: String,
    },
    /// It is of another run.
    #[error("is of another {what}: {found}, not {expected}")]
    Foreign {
        /// What differs.
        what: &'static str,
        /// In the file.
        found: String,
        /// Here.
        expected: String,
    },
}
