//! Solves a scene from its text, for programs that embed one.

use crate::built_in::ALL;
use crate::kind::{Options, Progress, RunError, kind_of};
use crate::ladder::{Answer, LadderError, read_answer};
use crate::scene::SceneFile;

/// Error of [`solve`].
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum SolveError {
    /// The scene is invalid, or its run ended in an error.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// No temporary folder is available, or the result cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Result(#[from] LadderError),
}

/// Runs a scene in a temporary folder and returns its quantities at the last time, each with its error.
///
/// # Errors
/// [`SolveError`]; an invalid scene is [`RunError::Scene`], with line and column.
pub fn solve(scene: &SceneFile) -> Result<Answer, SolveError> {
    let kind = kind_of(ALL, scene)?;
    let folder = tempfile::tempdir().map_err(LadderError::Folder)?;
    let options = Options::new(folder.path()).without_page();
    kind.run_file(scene, &options, &Progress::silent())?;
    Ok(read_answer(kind, folder.path())?)
}
