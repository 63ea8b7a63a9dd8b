//! Parts of an ensemble that run separately and are merged.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Part of an ensemble to compute.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EnsemblePart {
    /// The whole ensemble.
    Whole,
    /// One shard, written to a file.
    Shard(Place),
    /// The result of all shards, read from their files.
    Merged(Vec<PathBuf>),
}

/// Position of a shard, from 1, and number of shards: `2/4`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Place {
    pub(super) shard: u64,
    pub(super) of: u64,
}

/// The text is no position of a shard.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` must be K/N with N shards and K from 1 to N, e.g. 2/4")]
pub struct PlaceError {
    text: String,
}

/// The shards are not one ensemble.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShardsError {
    /// No file was given.
    #[error("no shard file was given")]
    None,
    /// A shard is missing.
    #[error("shard {0} is missing")]
    Missing(Place),
    /// A shard is given twice.
    #[error("shard {place} is given twice, the second time by {}", .file.display())]
    Doubled {
        /// The shard.
        place: Place,
        /// Its second file.
        file: PathBuf,
    },
    /// A shard has the wrong number of results.
    #[error("a shard has {found} {what}; {expected} are required")]
    OtherContent {
        /// Kind of results.
        what: &'static str,
        /// Number in the shard.
        found: usize,
        /// Required number.
        expected: usize,
    },
    /// A shard belongs to another division.
    #[error("{} is shard {place}; the first file is one of {expected}", .file.display())]
    OtherDivision {
        /// The shard.
        place: Place,
        /// Its file.
        file: PathBuf,
        /// Number of shards in the first file.
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
    /// Number of shards.
    #[must_use]
    pub const fn n_shards(self) -> u64 {
        self.of
    }

    /// Its part of `n` items, in order; sizes of parts differ by at most one.
    #[must_use]
    pub fn of(self, n: u64) -> Range<u64> {
        let bound = |k: u64| n / self.of * k + (n % self.of).min(k);
        bound(self.shard - 1)..bound(self.shard)
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
