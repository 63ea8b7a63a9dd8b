//! Solves a scene from its text, for programs that embed one.

use crate::answers::Answers;
use crate::built_in::ALL;
use crate::kind::{Progress, RunError, kind_of};
use crate::scene::SceneFile;

/// Runs a scene in memory and returns its answers, each value with its error. Nothing is written.
///
/// # Errors
/// [`RunError`]; an invalid scene is [`RunError::Scene`], with line and column.
pub fn solve(scene: &SceneFile) -> Result<Answers, RunError> {
    kind_of(ALL, scene)?.solve(scene, None, &Progress::silent())
}
