//! A scene from its text to its quantities, for programs that embed one.

use crate::built_in::ALL;
use crate::kind::{Options, Progress, RunError, kind_of};
use crate::ladder::{Answer, LadderError, read_answer};
use crate::scene::SceneFile;

/// Why a scene has no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum SolveError {
    /// The scene is wrong, or its run ended in an error.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// There is no temporary folder, or the result cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Result(#[from] LadderError),
}

/// Runs a scene in a temporary folder and returns its quantities at the last time, each with its error.
///
/// # Errors
/// [`SolveError`]; a mistake in the scene is [`RunError::Scene`], with line and column.
pub fn solve(scene: &SceneFile) -> Result<Answer, SolveError> {
    let kind = kind_of(ALL, scene)?;
    let folder = tempfile::tempdir().map_err(LadderError::Folder)?;
    kind.run_file(scene, &Options::new(folder.path()), &Progress::silent())?;
    Ok(read_answer(kind, folder.path())?)
}
