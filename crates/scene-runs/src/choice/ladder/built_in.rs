//! The built-in scenes with every method that solves them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Ladder, Limits, Method, Rung, Trial, climb, try_scene};
use crate::kind::{RunError, SceneKind, kind_of};
use crate::scene::SceneFile;
use crate::scene::folder::files_by_name;

/// A built-in scene.
pub struct BuiltIn {
    /// Folder and name, e.g. `fpk/viscous_damper`.
    pub name: String,
    /// Its text.
    pub file: SceneFile,
    /// Its kind.
    pub kind: &'static SceneKind,
    /// Methods that solve it.
    pub ladder: Arc<Ladder>,
}

/// Error of a built-in scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuiltInError {
    /// The scene cannot be read or is invalid.
    #[error("the scene {name} failed")]
    Scene {
        /// Name of the scene.
        name: String,
        /// Cause.
        source: RunError,
    },
    /// The folder cannot be listed.
    #[error("cannot list {}", .folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Error of the file system.
        source: std::io::Error,
    },
}

impl BuiltIn {
    /// All scenes in the folders below `root` that methods can be compared on, by name: those of a kind without a ladder, such as
    /// inference, and files that are no scenes are left out.
    ///
    /// # Errors
    /// [`BuiltInError`].
    pub fn all(table: &'static [SceneKind], root: &Path) -> Result<Vec<Self>, BuiltInError> {
        let files = files_by_name(root);
        let files = files.map_err(|(folder, source)| BuiltInError::Folder { folder, source })?;
        let scenes = files.into_iter().filter_map(|(name, path)| Self::read(table, name, &path));
        scenes.collect()
    }

    /// A scene with its ladder; none for a kind without one.
    fn read(
        table: &'static [SceneKind],
        name: String,
        path: &Path,
    ) -> Option<Result<Self, BuiltInError>> {
        let read = || -> Result<_, RunError> {
            let file = SceneFile::read(path)?;
            let kind = kind_of(table, &file)?;
            let ladder = Arc::new((kind.ladder)(&file)?);
            Ok((file, kind, ladder))
        };
        match read() {
            Ok((file, kind, ladder)) => Some(Ok(Self { name, file, kind, ladder })),
            Err(RunError::NoLadder { .. }) => None,
            Err(source) => Some(Err(BuiltInError::Scene { name, source })),
        }
    }

    /// Climbs the ladders of all methods until a trial would cost more than the budget (CPU s); see [`climb`].
    pub fn trials(&self, budget: f64, mut tell: impl FnMut(&Method, &Rung)) -> Vec<Trial> {
        let limits = Limits { budget, longest: None };
        let methods = 0..self.ladder.methods.len();
        methods
            .flat_map(|method| {
                climb(self.kind, &self.file, &self.ladder, method, limits, &mut tell)
            })
            .collect()
    }

    /// CPU times (s) of a trial and of its repetitions, in increasing order; empty for a trial without answers.
    #[must_use]
    pub fn costs(&self, trial: &Trial, again: usize) -> Vec<f64> {
        let Some(answers) = trial.answers() else { return Vec::new() };
        let repeated = (0..again).filter_map(|_| {
            let outcome = try_scene(self.kind, &self.file, &trial.rung.trial, None);
            Some(outcome.answers()?.cpu_seconds)
        });
        let mut costs: Vec<f64> = std::iter::once(answers.cpu_seconds).chain(repeated).collect();
        costs.sort_by(f64::total_cmp);
        costs
    }
}

impl std::fmt::Debug for BuiltIn {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("BuiltIn").field("name", &self.name).finish_non_exhaustive()
    }
}
