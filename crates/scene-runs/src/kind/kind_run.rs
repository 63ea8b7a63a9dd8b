//! Context that a scene kind receives for a run.

use std::path::Path;
use std::sync::OnceLock;

use mpi_ensembles::Ranks;

use super::folder_lock::FolderLock;
use super::options::Options;
use super::pace::{Limit, Pace};
use super::progress::Progress;
use super::run_error::RunError;
use crate::checkpoint::Checkpoint;
use crate::scene::{Scene, SceneFile};

/// Where the results of a run go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Results {
    /// Into the folder of the options.
    InFolder,
    /// Back to the caller alone.
    InMemory,
}

/// Context of a run.
#[derive(Debug)]
pub struct Run<'a> {
    /// Progress reporter.
    pub progress: &'a Progress,
    pub(super) solver: &'static str,
    pub(super) options: &'a Options,
    pub(super) results: Results,
    pub(super) checkpoint: OnceLock<Checkpoint>,
    pub(super) lock: OnceLock<FolderLock>,
    pub(super) ranks: Option<&'a dyn Ranks>,
}

impl Run<'_> {
    /// Folder of the results; none of a run whose answers stay in memory, which touches no file.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        (self.results == Results::InFolder).then_some(&self.options.out)
    }

    /// The pace of a part of this run.
    #[must_use]
    pub fn pace(&self, what: &'static str) -> Pace<'_> {
        self.limit().pace(what)
    }

    /// What the parts of this run are held to.
    #[must_use]
    pub fn limit(&self) -> Limit<'_> {
        Limit { longest: self.options.longest, progress: self.progress }
    }

    /// Parses a scene, replaces its seed if requested, and returns it with the result of its check. From then on the folder of the
    /// results is closed to other runs, except for the ranks of the same job.
    ///
    /// # Errors
    /// [`RunError::Scene`]; [`RunError::NoSeed`] for a seed given to a scene without random numbers; [`RunError::Occupied`].
    pub fn build<T: Scene>(&self, file: &SceneFile) -> Result<(T, T::Built), RunError> {
        let (mut scene, built) = file.build::<T>()?;
        if let Some(seed) = self.options.seed {
            *scene.seed().ok_or(RunError::NoSeed { seed })? = seed;
        }
        if let (None, None, Some(folder)) = (self.ranks, self.lock.get(), self.folder()) {
            // A second call, of the same thread, finds the lock that the first has set.
            let _ = self.lock.set(FolderLock::take(folder)?);
        }
        Ok((scene, built))
    }
}
