//! Errors of a run.

use std::path::PathBuf;

use mpi_ensembles::JobError;
use result_figures::finite::JsonError;

use super::pace::{Pace, TooLong};
use super::part::ShardsError;
use crate::checkpoint::CheckpointError;
use crate::interrupt;
use crate::output::OutputError;
use crate::scene::SceneError;

/// Any error of a solver, a case or a chart, boxed so that `?` converts all of them.
pub type SolverError = Box<dyn std::error::Error + Send + Sync>;

/// Error of a run.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum RunError {
    /// The scene is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// This build has no scene kind.
    #[error("this build supports no solver")]
    NoKinds,
    /// The solver rejected its input or stopped.
    #[error("the run ended in an error")]
    Solver(#[source] SolverError),
    /// A result could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The checkpoint was rejected, or could not be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The page of the results could not be made.
    #[error("the results are written, but not their page")]
    Page(#[source] SolverError),
    /// The scene or its result has a value that JSON cannot represent.
    #[error("the scene, or its result, has a value that JSON cannot represent")]
    Json(#[from] JsonError),
    /// The method of the scene has no shards, but shards were requested or given.
    #[error("the method of the scene has no shards")]
    #[diagnostic(help("run it in one process and without --shard; there is nothing to merge"))]
    NoShards,
    /// The numbers of samples follow from those before, but shards were requested or given.
    #[error(
        "the method of the scene plans its samples by those before: no shard knows beforehand which are its own"
    )]
    #[diagnostic(help(
        "run it in one process, on all cores, and without --shard; `monte_carlo` has shards and ranks"
    ))]
    NoShardsOfAPlan,
    /// The scene has no other methods or sizes with which its own could be compared.
    #[error("a scene of `{solver}` has one method and one size: {reason}")]
    NoLadder {
        /// The solver.
        solver: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// The run would take longer than allowed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    TooLong(#[from] TooLong),
    /// A signal ended a part of which nothing is kept.
    #[error("interrupted: nothing is kept of this method, and the run starts from the beginning")]
    Interrupted,
    /// The shards are not one ensemble.
    #[error(transparent)]
    Shards(#[from] ShardsError),
    /// A rank of the job failed.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The folder holds blocks of another run, and this run starts from the beginning.
    #[error("{} contains {found} blocks of a run", folder.display())]
    #[diagnostic(help("--resume continues from them, --overwrite removes them"))]
    BlocksLeft {
        /// The folder of the blocks.
        folder: PathBuf,
        /// Number of blocks.
        found: usize,
    },
    /// A shard was requested on ranks, which share an ensemble themselves.
    #[error("a shard of an ensemble, or a merge, runs in one process")]
    #[diagnostic(help("leave out --shard, or mpirun"))]
    PartOnRanks,
    /// Another run writes into the folder.
    #[error("another run writes into {}", folder.display())]
    #[diagnostic(help("wait for its end, or choose another folder by --out"))]
    Occupied {
        /// The folder.
        folder: PathBuf,
    },
    /// The scene has no random numbers.
    #[error("the seed {seed} was given, but the scene has no random numbers")]
    #[diagnostic(help("leave out --seed"))]
    NoSeed {
        /// The seed.
        seed: u64,
    },
}

impl RunError {
    /// Refuses a part without checkpoints that has ended early, by a signal or by its pace.
    ///
    /// # Errors
    /// [`RunError::Interrupted`], [`RunError::TooLong`].
    pub fn if_ended_early(pace: &Pace<'_>) -> Result<(), Self> {
        if interrupt::is_requested() {
            return Err(Self::Interrupted);
        }
        Ok(pace.allowed()?)
    }

    /// Converts any error of a page.
    pub fn page(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Page(Box::new(error))
    }

    /// Converts any error of a solver: `simulation.step().map_err(RunError::solver)?`.
    pub fn solver(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Solver(Box::new(error))
    }
}
