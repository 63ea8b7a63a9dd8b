//! Solves a scene from its text, for programs that embed one.

use scene_runs::answers::Answers;
use scene_runs::kind::{Progress, RunError, kind_of};
use scene_runs::scene::SceneFile;

use crate::built_in::ALL;

/// Runs a scene in memory and returns its answers, each value with its error. Nothing is written.
///
/// # Errors
/// [`RunError`]; an invalid scene is [`RunError::Scene`], with line and column.
pub fn solve(scene: &SceneFile) -> Result<Answers, RunError> {
    kind_of(ALL, scene)?.solve(scene, None, &Progress::silent())
}
