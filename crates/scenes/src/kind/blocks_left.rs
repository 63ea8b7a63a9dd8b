//! Error for a restart over blocks of another run.

use std::path::PathBuf;

/// The folder holds blocks of another run, and this run starts from the beginning.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{} contains {found} blocks of a run", .folder.display())]
#[diagnostic(help("--resume continues from them, --overwrite removes them"))]
pub struct BlocksLeft {
    pub(super) folder: PathBuf,
    pub(super) found: usize,
}
