//! The refusal to start anew over blocks of another run.

use std::path::PathBuf;

/// Blocks of another run in the folder of one that would start anew.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{} holds {found} blocks of a run", .folder.display())]
#[diagnostic(help("--resume goes on from them, --overwrite removes them"))]
pub struct BlocksLeft {
    pub(super) folder: PathBuf,
    pub(super) found: usize,
}
