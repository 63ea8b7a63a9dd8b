//! Context that a scene kind receives for a run.

use std::path::Path;
use std::sync::OnceLock;

use mpi_ensembles::Ranks;

use super::folder_lock::FolderLock;
use super::options::{Options, PageFile};
use super::pace::{Limit, Pace};
use super::progress::Progress;
use super::run_error::RunError;
use crate::checkpoint::Checkpoint;
use crate::scene::{Scene, SceneFile};

/// Context of a run.
#[derive(Debug)]
pub struct Run<'a> {
    /// Progress reporter.
    pub progress: &'a Progress,
    pub(super) solver: &'static str,
    pub(super) options: &'a Options,
    pub(super) checkpoint: OnceLock<Checkpoint>,
    pub(super) lock: OnceLock<FolderLock>,
    pub(super) ranks: Option<&'a dyn Ranks>,
}

impl Run<'_> {
    /// Folder of the results.
    #[must_use]
    pub fn out(&self) -> &Path {
        &self.options.out
    }

    /// Whether the results get a page.
    #[must_use]
    pub fn page(&self) -> PageFile {
        self.options.page
    }

    /// The pace of a part of this run.
    pub(crate) fn pace(&self, what: &'static str) -> Pace<'_> {
        self.limit().pace(what)
    }

    /// What the parts of this run are held to.
    pub(crate) fn limit(&self) -> Limit<'_> {
        Limit { longest: self.options.longest, progress: self.progress }
    }

    /// Parses a scene, replaces its seed if requested, and returns it with the result of its check. From then on the folder of the
    /// results is closed to other runs, but for the ranks of the same job.
    ///
    /// # Errors
    /// [`RunError::Scene`]; [`RunError::NoSeed`] for a seed given to a scene without random numbers; [`RunError::Occupied`].
    pub fn build<T: Scene>(&self, file: &SceneFile) -> Result<(T, T::Built), RunError> {
        let (mut scene, built) = file.build::<T>()?;
        if let Some(seed) = self.options.seed {
            *scene.seed().ok_or(RunError::NoSeed { seed })? = seed;
        }
        if self.ranks.is_none() && self.lock.get().is_none() {
            // A second call, of the same thread, finds the lock that the first has set.
            let _ = self.lock.set(FolderLock::take(self.out())?);
        }
        Ok((scene, built))
    }
}
