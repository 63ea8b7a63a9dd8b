//! Inputs that determine the results of a run, and so identify its checkpoints and shards.

use result_figures::finite::JsonError;
use serde::Serialize;

use super::kind_run::Run;
use super::part::EnsemblePart;
use super::run_error::RunError;
use crate::checkpoint::{Checkpoint, Head, Start};
use crate::scene::NamedFile;

/// Inputs of a run.
#[derive(Debug)]
pub struct Inputs<'a, T> {
    /// The parsed scene.
    pub scene: &'a T,
    /// Seed of its random numbers.
    pub seed: Option<u64>,
    /// All files that it names.
    pub files: &'a [NamedFile],
}

impl<T: Serialize> Inputs<'_, T> {
    /// All parts of a scene that affect its results; `aside` are JSON pointers of excluded keys.
    fn identity(&self, aside: &[&str]) -> Result<serde_json::Value, RunError> {
        let mut identity = serde_json::to_value(self.scene).map_err(JsonError::from)?;
        for pointer in aside {
            if let Some(value) = identity.pointer_mut(pointer) {
                *value = serde_json::Value::Null;
            }
        }
        Ok(identity)
    }
}

impl Run<'_> {
    /// The checkpoint of a run of a scene; it ends with the run.
    ///
    /// `aside` are the JSON pointers of keys that do not affect the results so far: title, end time, output.
    ///
    /// # Errors
    /// [`RunError::Checkpoint`]; [`RunError::Json`] for a scene that JSON cannot represent.
    pub fn checkpoint(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        aside: &[&str],
    ) -> Result<&Checkpoint, RunError> {
        let Some(folder) = self.folder() else {
            return Ok(self.checkpoint.get_or_init(Checkpoint::in_memory));
        };
        let mut identity = inputs.identity(aside)?;
        if let (EnsemblePart::Shard(place), Some(identity)) =
            (self.part(), identity.as_object_mut())
        {
            identity.insert("shard".to_owned(), place.to_string().into());
        }
        let head = Head::new(self.solver, &identity, inputs.seed, inputs.files);
        let start = self.options.start;
        let (checkpoint, found) =
            Checkpoint::open(folder, head, start, self.options.checkpoint_every)?;
        for refused in &found.refused {
            self.progress.stage(&format!("not resumed: {refused}"));
        }
        match (start, found.file) {
            (Start::Anew | Start::Overwrite, _) => {}
            (Start::GoOn, Some(file)) => {
                self.progress.stage(&format!("resumes from {}", file.display()));
            }
            (Start::GoOn, None) => {
                let folder = folder.display();
                self.progress
                    .stage(&format!("no checkpoint in {folder}: starts from the beginning"));
            }
        }
        Ok(self.checkpoint.get_or_init(|| checkpoint))
    }

    /// Identity of the files of shards.
    pub(super) fn shard_head(&self, inputs: &Inputs<'_, impl Serialize>) -> Result<Head, RunError> {
        let identity = inputs.identity(&["/title"])?;
        Ok(Head::of_shards(self.solver, &identity, inputs.seed, inputs.files))
    }

    /// Identity of blocks: the instruction set of all ranks must be the same.
    pub(super) fn block_head(&self, inputs: &Inputs<'_, impl Serialize>) -> Result<Head, RunError> {
        let identity = inputs.identity(&["/title"])?;
        Ok(Head::new(self.solver, &identity, inputs.seed, inputs.files))
    }
}
