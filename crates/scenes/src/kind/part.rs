//! Parts of an ensemble that are run apart, and joined.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Inputs, Run, RunError};
use crate::checkpoint::{read_file, write_file};

/// What is done of an ensemble.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// All.
    Whole,
    /// A shard of it, which leaves a file.
    Shard(Place),
    /// The result of all shards, from their files.
    Merged(Vec<PathBuf>),
}

/// Which shard, from 1 on, and of how many: `2/4`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Place {
    shard: u64,
    of: u64,
}

/// A text that is no place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` must be K/N with N shards and K from 1 to N, e.g. 2/4")]
pub struct PlaceError {
    text: String,
}

/// Shards that are not one ensemble.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShardsError {
    /// None was given.
    #[error("no file of a shard was given")]
    None,
    /// One is missing.
    #[error("shard {0} is missing")]
    Missing(Place),
    /// One is there twice.
    #[error("shard {place} is given twice, the second time by {}", .file.display())]
    Doubled {
        /// Which.
        place: Place,
        /// The second.
        file: PathBuf,
    },
    /// One holds what no shard of the scene does.
    #[error("a shard holds {found} {what}, {expected} expected")]
    OtherContent {
        /// Of what.
        what: &'static str,
        /// How many.
        found: usize,
        /// How many it must hold.
        expected: usize,
    },
    /// One is of another division.
    #[error("{} is shard {place}; the first file is one of {expected}", .file.display())]
    OtherDivision {
        /// Which.
        place: Place,
        /// Its file.
        file: PathBuf,
        /// How many the first file says.
        expected: u64,
    },
}

impl FromStr for Place {
    type Err = PlaceError;

    fn from_str(text: &str) -> Result<Self, PlaceError> {
        let place = text.split_once('/').and_then(|(shard, of)| {
            let (shard, of) = (shard.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&shard).then_some(Self { shard, of })
        });
        place.ok_or_else(|| PlaceError { text: text.to_owned() })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.shard, self.of)
    }
}

impl Place {
    /// Of how many.
    #[must_use]
    pub const fn n_shards(self) -> u64 {
        self.of
    }

    /// Its part of `n` things, in order; parts differ by one at most.
    #[must_use]
    pub fn of(self, n: u64) -> Range<u64> {
        let bound = |k: u64| n / self.of * k + (n % self.of).min(k);
        bound(self.shard - 1)..bound(self.shard)
    }
}

impl Run<'_> {
    /// What is to be done of the ensemble.
    #[must_use]
    pub fn part(&self) -> &Part {
        &self.options.part
    }

    /// Its part of `n` things.
    #[must_use]
    pub fn range(&self, n: u64) -> Range<u64> {
        match &self.options.part {
            Part::Shard(place) => place.of(n),
            Part::Whole | Part::Merged(_) => 0..n,
        }
    }

    /// Refuses shards, and ranks that would share them, for a method that has none.
    ///
    /// # Errors
    /// [`RunError::NoShards`].
    pub fn no_shards(&self) -> Result<(), RunError> {
        let is_whole = self.options.part == Part::Whole && self.ranks.is_none();
        if is_whole { Ok(()) } else { Err(RunError::NoShards) }
    }

    /// Writes `shard-2-of-4.bin`, which holds what a shard has come to and of which scene and files it is.
    ///
    /// # Errors
    /// [`RunError::Checkpoint`], [`RunError::Identity`].
    pub fn write_shard<T: Serialize>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        place: Place,
        content: &T,
    ) -> Result<PathBuf, RunError> {
        let path = self.out().join(format!("shard-{}-of-{}.bin", place.shard, place.of));
        write_file(&path, &self.shard_head(inputs)?, &(place, content))?;
        Ok(path)
    }

    /// Refuses a shard that holds another number of things than it must.
    ///
    /// # Errors
    /// [`RunError::Shards`].
    pub(crate) fn require(
        what: &'static str,
        found: usize,
        expected: usize,
    ) -> Result<(), RunError> {
        if found == expected {
            return Ok(());
        }
        Err(ShardsError::OtherContent { what, found, expected }.into())
    }

    /// Reads the files of all shards of a scene, given in any order.
    ///
    /// # Errors
    /// [`RunError::Checkpoint`] for a file that is damaged, of another scene, or made with other files; [`RunError::Shards`] for one that is missing, there
    /// twice, or of another division.
    pub fn read_shards<T: DeserializeOwned>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        files: &[PathBuf],
    ) -> Result<Vec<T>, RunError> {
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
            None => Ok(shards.into_iter().map(|(_, content)| content).collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_everything_once_and_differ_by_one() {
        for n in [0, 1, 7, 100] {
            let parts: Vec<Range<u64>> =
                (1..=7).map(|k| format!("{k}/7").parse::<Place>().unwrap().of(n)).collect();
            assert_eq!((parts[0].start, parts[6].end), (0, n));
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start));
            let lengths = parts.iter().map(|part| part.end - part.start);
            assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1);
        }
    }

    #[test]
    fn what_is_no_place_is_refused_by_its_words() {
        for text in ["", "2", "0/4", "5/4", "1/0", "a/b", "-1/4", "1/2/3"] {
            let error = text.parse::<Place>().unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{text}` must be K/N")), "{error}");
        }
    }
}
