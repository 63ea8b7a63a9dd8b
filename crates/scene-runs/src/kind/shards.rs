//! The part of an ensemble that a run computes, and the files of its shards.

use std::ops::Range;
use std::path::PathBuf;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::inputs::Inputs;
use super::kind_run::Run;
use super::part::{EnsemblePart, Place, ShardsError};
use super::run_error::RunError;
use crate::checkpoint::{Survives, read_file, write_file};

impl Run<'_> {
    /// Part of the ensemble to compute.
    #[must_use]
    pub fn part(&self) -> &EnsemblePart {
        &self.options.part
    }

    /// Its part of `n` items.
    #[must_use]
    pub fn range(&self, n: u64) -> Range<u64> {
        match &self.options.part {
            EnsemblePart::Shard(place) => place.of(n),
            EnsemblePart::Whole | EnsemblePart::Merged(_) => 0..n,
        }
    }

    /// Rejects shards and ranks for a method that has no shards.
    ///
    /// # Errors
    /// [`RunError::NoShards`].
    pub fn no_shards(&self) -> Result<(), RunError> {
        let is_whole = self.options.part == EnsemblePart::Whole && self.ranks.is_none();
        if is_whole { Ok(()) } else { Err(RunError::NoShards) }
    }

    /// Rejects shards and ranks for a method whose plan follows from its samples.
    ///
    /// # Errors
    /// [`RunError::NoShardsOfAPlan`].
    pub fn no_shards_of_a_plan(&self) -> Result<(), RunError> {
        self.no_shards().map_err(|_| RunError::NoShardsOfAPlan)
    }

    /// Writes `shard-2-of-4.bin` with the results of a shard and the identity of its scene and files.
    ///
    /// # Errors
    /// [`RunError::Checkpoint`], [`RunError::Json`].
    pub fn write_shard<T: Serialize>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        place: Place,
        content: &T,
    ) -> Result<PathBuf, RunError> {
        let path = self.options.out.join(format!("shard-{}-of-{}.bin", place.shard, place.of));
        write_file(&path, &self.shard_head(inputs)?, &(place, content), Survives::Machine)?;
        Ok(path)
    }

    /// Rejects a shard with the wrong number of results.
    ///
    /// # Errors
    /// [`RunError::Shards`].
    pub fn require(what: &'static str, found: usize, expected: usize) -> Result<(), RunError> {
        if found == expected {
            return Ok(());
        }
        Err(ShardsError::OtherContent { what, found, expected }.into())
    }

    /// The shards of a scene, whose files may be given in any order, if they are to be merged.
    ///
    /// # Errors
    /// [`RunError::Checkpoint`] for a file that is damaged, of another scene, or made with other files;
    /// [`RunError::Shards`] for a shard that is missing, duplicated, or of another division.
    pub fn shards<T: DeserializeOwned>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
    ) -> Result<Option<Vec<T>>, RunError> {
        let EnsemblePart::Merged(files) = self.part() else { return Ok(None) };
        let head = self.shard_head(inputs)?;
        let mut shards: Vec<(Place, T)> = Vec::new();
        for file in files {
            let (place, content): (Place, T) = read_file(file, &head)?;
            let expected = shards.first().map_or(place.of, |(first, _)| first.of);
            if place.of != expected {
                return Err(
                    ShardsError::OtherDivision { place, file: file.clone(), expected }.into()
                );
            }
            if shards.iter().any(|(other, _)| *other == place) {
                return Err(ShardsError::Doubled { place, file: file.clone() }.into());
            }
            shards.push((place, content));
        }
        let Some(&(Place { of, .. }, _)) = shards.first() else {
            return Err(ShardsError::None.into());
        };
        shards.sort_by_key(|(place, _)| *place);
        let mut all = (1..=of).map(|shard| Place { shard, of });
        let missing = all.find(|place| shards.iter().all(|(found, _)| found != place));
        match missing {
            Some(place) => Err(ShardsError::Missing(place).into()),
            None => Ok(Some(shards.into_iter().map(|(_, content)| content).collect())),
        }
    }
}
