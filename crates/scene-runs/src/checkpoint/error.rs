//! Errors of a checkpoint.

use std::path::PathBuf;

/// Error of reading or writing a checkpoint.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum CheckpointError {
    /// Files exist, but none can be resumed.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    #[diagnostic(help(
        "--overwrite starts from the beginning; join shards by the scene that produced them"
    ))]
    Refused(Vec<Refusal>),
    /// The run would restart over an unfinished run.
    #[error("{} belongs to an unfinished run", .path.display())]
    #[diagnostic(help(
        "--resume continues it, --overwrite starts from the beginning, another --out keeps it"
    ))]
    Unfinished {
        /// The last checkpoint.
        path: PathBuf,
    },
    /// A signal ended the run.
    #[error("interrupted; {} holds the run up to here", .path.display())]
    #[diagnostic(help(
        "--resume continues it; the results are bitwise identical to those of an uninterrupted run"
    ))]
    Interrupted {
        /// The last checkpoint.
        path: PathBuf,
    },
    /// A signal ended a run without a folder.
    #[error("interrupted; nothing of the run is kept")]
    NotKept,
    /// The content of a part does not match its name.
    #[error("the part `{name}` of the checkpoint is invalid")]
    Part {
        /// Name of the part.
        name: String,
        /// Error of the decoder.
        source: postcard::Error,
    },
    /// The file system returned an error.
    #[error("cannot read or write the checkpoint {}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the file system.
        source: std::io::Error,
    },
}

/// A file that cannot be resumed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} {reason}", .path.display())]
pub struct Refusal {
    /// The file.
    pub path: PathBuf,
    /// Reason.
    pub reason: Reason,
}

/// Why a file cannot be resumed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// It has no checkpoint signature.
    #[error("is not a checkpoint")]
    NoCheckpoint,
    /// It was written by a version with another layout of these files.
    #[error("is a checkpoint of another version of scenes")]
    OtherLayout,
    /// Keys of the scene that affect the results have changed.
    #[error("is of another scene: {keys}")]
    OtherScene {
        /// The keys, with their values then and now.
        keys: String,
    },
    /// Its length is wrong.
    #[error("is cut off: it has {found} bytes of {expected}")]
    CutOff {
        /// Its actual length (bytes).
        found: u64,
        /// The length in its head (bytes).
        expected: u64,
    },
    /// Its hash does not match its bytes.
    #[error("is damaged: its bytes have the hash {found:016x}, stored is {expected:016x}")]
    Damaged {
        /// Hash of its bytes.
        found: u64,
        /// Hash stored at its end.
        expected: u64,
    },
    /// A file named by the scene has changed.
    #[error("was made with another {file}: its bytes had the hash {found}, now it is {expected}")]
    OtherFile {
        /// Path of that file, as given in the scene.
        file: String,
        /// XXH64 at the time of the run.
        found: String,
        /// XXH64 now.
        expected: String,
    },
    /// It belongs to another run.
    #[error("is of another {what}: {found}, not {expected}")]
    Foreign {
        /// Name of the field that differs.
        what: &'static str,
        /// Value in the file.
        found: String,
        /// Value of this run.
        expected: String,
    },
}
