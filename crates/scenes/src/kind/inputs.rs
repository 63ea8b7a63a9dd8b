//! What the numbers of a run depend on, by which its checkpoints and shards are told from others.

use figures::finite::JsonError;
use serde::Serialize;

use super::kind_run::Run;
use super::part::Part;
use super::run_error::RunError;
use crate::checkpoint::{Checkpoint, Head, Start};
use crate::scene::NamedFile;

/// What a run was made from.
#[derive(Debug)]
pub struct Inputs<'a, T> {
    /// The scene as it was understood.
    pub scene: &'a T,
    /// The seed of what it draws.
    pub seed: Option<u64>,
    /// The files that it names, all of them.
    pub files: &'a [NamedFile],
}

impl<T: Serialize> Inputs<'_, T> {
    /// All of a scene that its numbers depend on; `aside` are the JSON pointers of what is left out.
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
    /// The checkpoint of the run of a scene, which ends with it. `aside` are the JSON pointers of what its numbers do not depend on: its title, its end,
    /// and what only looks at the result.
    ///
    /// # Errors
    /// [`RunError::Checkpoint`]; [`RunError::Identity`] for a scene that is no JSON.
    pub fn checkpoint(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        aside: &[&str],
    ) -> Result<&Checkpoint, RunError> {
        let mut identity = inputs.identity(aside)?;
        if let (Part::Shard(place), Some(identity)) = (self.part(), identity.as_object_mut()) {
            identity.insert("shard".to_owned(), place.to_string().into());
        }
        let head = Head::new(self.solver, &identity, inputs.seed, inputs.files);
        let start = self.options.start;
        let (checkpoint, found) =
            Checkpoint::open(self.out(), head, start, self.options.checkpoint_every)?;
        for refused in &found.refused {
            self.progress.stage(&format!("not gone on from: {refused}"));
        }
        match (start, found.file) {
            (Start::Anew | Start::Overwrite, _) => {}
            (Start::GoOn, Some(file)) => {
                self.progress.stage(&format!("goes on from {}", file.display()));
            }
            (Start::GoOn, None) => {
                let folder = self.out().display();
                self.progress
                    .stage(&format!("no checkpoint in {folder}: starts from the beginning"));
            }
        }
        Ok(self.checkpoint.get_or_init(|| checkpoint))
    }

    /// Whose the files of shards are.
    pub(super) fn shard_head(&self, inputs: &Inputs<'_, impl Serialize>) -> Result<Head, RunError> {
        let identity = inputs.identity(&["/title"])?;
        Ok(Head::of_shards(self.solver, &identity, inputs.seed, inputs.files))
    }

    /// Whose blocks are: the instructions of all ranks must be the same.
    pub(super) fn block_head(&self, inputs: &Inputs<'_, impl Serialize>) -> Result<Head, RunError> {
        let identity = inputs.identity(&["/title"])?;
        Ok(Head::new(self.solver, &identity, inputs.seed, inputs.files))
    }
}
