//! Why a scene was not run to its end.

use figures::finite::JsonError;
use mpi_ensembles::JobError;

use super::blocks_left::BlocksLeft;
use super::part::ShardsError;
use crate::checkpoint::CheckpointError;
use crate::output::OutputError;
use crate::scene::SceneError;

/// Why a solver refused or stopped, or a case or chart could not run to its end: any typed error, so that `?` takes them all.
pub type SolverError = Box<dyn std::error::Error + Send + Sync>;

/// Why a scene was not run to its end.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum RunError {
    /// The scene is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// There is no kind of scene yet.
    #[error("no kind of scene can be run yet")]
    NoKinds,
    /// The solver refused or stopped.
    #[error("the run ended in an error")]
    Solver(#[source] SolverError),
    /// A result could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The checkpoint was refused, or could not be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The scene cannot be told from others.
    #[error("the scene holds what JSON does not")]
    Identity(#[from] JsonError),
    /// Shards were asked for, or given, and the method of the scene has none.
    #[error("the method of the scene has no shards")]
    #[diagnostic(help("run it in one process and without --shard; there is nothing to merge"))]
    NoShards,
    /// Shards that are not one ensemble.
    #[error(transparent)]
    Shards(#[from] ShardsError),
    /// The ranks of a job did not come to its end.
    #[error(transparent)]
    Job(#[from] JobError),
    /// A run would start anew over blocks of another.
    #[error(transparent)]
    #[diagnostic(transparent)]
    BlocksLeft(#[from] BlocksLeft),
    /// The ranks of a job share an ensemble among themselves.
    #[error("a shard of an ensemble, or its merge, is the work of one process")]
    #[diagnostic(help("leave out --shard, or mpirun"))]
    PartOnRanks,
    /// Nothing in the scene is random.
    #[error("the seed {seed} was given, and the scene draws nothing at random")]
    #[diagnostic(help("leave out --seed"))]
    NoSeed {
        /// The seed.
        seed: u64,
    },
}

impl RunError {
    /// Takes any error of a solver: `simulation.step().map_err(RunError::solver)?`.
    pub fn solver(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Solver(Box::new(error))
    }
}
