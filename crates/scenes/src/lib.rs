#![doc = include_str!("../README.md")]

mod built_in;
#[cfg(feature = "cli")]
pub mod cli;

#[cfg(feature = "fpk")]
pub use fpk_scenes::{self as fpk, building};
#[cfg(feature = "peridyn")]
pub use peridyn_scenes::{self as peridyn, crack_inference};
pub use scene_runs::{
    Answer, Answers, BlockRecord, Cut, EnsemblePart, Finished, Found, Inputs, JobRecord, Options,
    Place, Progress, Run, RunError, SceneFile, SceneKind, SolverError, advise, answers, causes,
    check, checkpoint, clock, interrupt, kind, kind_of, ladder, machine, models, nearest, output,
    report, result_file, run, run_on_ranks, scene, schema,
};
#[cfg(feature = "smpm")]
pub use smpm_scenes as smpm;

pub use self::built_in::ALL;

/// Runs a scene in memory and returns its answers, each value with its error. Nothing is written.
///
/// # Errors
/// [`RunError`]; an invalid scene is [`RunError::Scene`], with line and column.
pub fn solve(scene: &SceneFile) -> Result<Answers, RunError> {
    kind_of(ALL, scene)?.solve(scene, None, &Progress::silent())
}
