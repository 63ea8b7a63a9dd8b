//! What a kind of scene is given to run one.

use std::path::Path;
use std::sync::OnceLock;

use mpi_ensembles::Ranks;

use super::options::Options;
use super::progress::Progress;
use super::run_error::RunError;
use crate::checkpoint::Checkpoint;
use crate::scene::{Scene, SceneFile};

/// What a kind of scene is given.
#[derive(Debug)]
pub struct Run<'a> {
    /// Hears what is being done.
    pub progress: &'a Progress,
    pub(super) solver: &'static str,
    pub(super) options: &'a Options,
    pub(super) checkpoint: OnceLock<Checkpoint>,
    pub(super) ranks: Option<&'a dyn Ranks>,
}

impl Run<'_> {
    /// Where the results go.
    #[must_use]
    pub fn out(&self) -> &Path {
        &self.options.out
    }

    /// Reads a scene, with the seed that was asked for in place of its own, and what its check built.
    ///
    /// # Errors
    /// [`RunError::Scene`]; [`RunError::NoSeed`] for a seed to a scene that has none.
    pub fn build<T: Scene>(&self, file: &SceneFile) -> Result<(T, T::Built), RunError> {
        let (mut scene, built) = file.build::<T>()?;
        if let Some(seed) = self.options.seed {
            *scene.seed().ok_or(RunError::NoSeed { seed })? = seed;
        }
        Ok((scene, built))
    }
}
