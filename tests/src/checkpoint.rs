//! What is kept of a run while it goes, so that it goes on to the same bits after it was killed.
//!
//! Two files take turns in the folder of the results, so that one of them is whole at any moment. Each has a head that says whose
//! it is, and ends in a hash of all that stands before. A kind of scene keeps parts in it, by name; what it keeps after the run has
//! ended serves a longer run of the same scene.

mod error;
mod file;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use self::error::{CheckpointError, Reason, Refusal};
pub use self::file::Head;

/// Between two checkpoints lie at least so many times the time that writing one takes.
const LEAST_SHARE: u32 = 50;

/// How a run begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// From nothing.
    Anew,
    /// From the last checkpoint in its folder; from nothing where there is none.
    GoOn,
}

/// Parts by their names, as bytes.
type Parts = BTreeMap<String, Vec<u8>>;

/// The checkpoint of a run.
#[derive(Debug)]
pub struct Checkpoint {
    folder: PathBuf,
    head: Head,
    every: Duration,
    kept: Mutex<Kept>,
}

#[derive(Debug)]
struct Kept {
    parts: Parts,
    /// How many files were written, by all runs that went on from each other.
    sequence: u64,
    last: Instant,
    /// How long the last took to write.
    took: Duration,
}

/// What was found at the start.
#[derive(Debug)]
pub struct Found {
    /// The file that the run goes on from.
    pub file: Option<PathBuf>,
    /// The files that were not taken, and why.
    pub refused: Vec<Refusal>,
}

impl Checkpoint {
    /// The checkpoint of the run that `head` names, in the folder of its results, written every so often.
    ///
    /// # Errors
    /// [`CheckpointError::Refused`] where files are there to go on from and none can be taken: one that is cut off or damaged, is of
    /// another scene, version or instruction set, or is no checkpoint; those of the file system.
    pub fn open(
        folder: &Path,
        head: Head,
        start: Start,
        every: Duration,
    ) -> Result<(Self, Found), CheckpointError> {
        let mut found = Found { file: None, refused: Vec::new() };
        let mut parts = Parts::new();
        let mut sequence = 0;
        if start == Start::GoOn {
            for path in file::names(folder) {
                match file::read(&path, &head)? {
                    Some(Err(refusal)) => found.refused.push(refusal),
                    Some(Ok((number, of_file))) if number > sequence => {
                        (parts, sequence) = (of_file, number);
                        found.file = Some(path);
                    }
                    Some(Ok(_)) | None => {}
                }
            }
            if found.file.is_none() && !found.refused.is_empty() {
                return Err(CheckpointError::Refused(found.refused));
            }
        }
        let kept = Kept { parts, sequence, last: Instant::now(), took: Duration::ZERO };
        Ok((Self { folder: folder.to_owned(), head, every, kept: Mutex::new(kept) }, found))
    }

    /// A part that an earlier run kept.
    ///
    /// # Errors
    /// [`CheckpointError::Part`] for a part that is not a `T`.
    pub fn part<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, CheckpointError> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.parts.get(name).map(|bytes| from_bytes(name, bytes)).transpose()
    }

    /// Whether the last checkpoint was long enough ago.
    #[must_use]
    pub fn is_due(&self) -> bool {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.last.elapsed() >= self.every.max(LEAST_SHARE * kept.took)
    }

    /// Keeps a part, in place of what stood under its name, and writes the checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError::Part`] for what has no form in bytes, and those of the file system.
    pub fn keep<T: Serialize>(&self, name: &str, part: &T) -> Result<(), CheckpointError> {
        let start = Instant::now();
        let bytes = to_bytes(name, part)?;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.parts.insert(name.to_owned(), bytes);
        kept.sequence += 1;
        let path = &file::names(&self.folder)[usize::from(kept.sequence % 2 == 1)];
        file::write(path, &self.head, kept.sequence, &kept.parts)?;
        kept.last = Instant::now();
        kept.took = start.elapsed();
        Ok(())
    }
}

/// What a file that holds one part calls it.
const ONLY: &str = "part";

/// Writes a file that holds one part, in the form of a checkpoint.
///
/// # Errors
/// As [`Checkpoint::keep`].
pub fn write_file<T: Serialize>(path: &Path, head: &Head, part: &T) -> Result<(), CheckpointError> {
    let parts = Parts::from([(ONLY.to_owned(), to_bytes(ONLY, part)?)]);
    file::write(path, head, 1, &parts)
}

/// Reads what [`write_file`] has written.
///
/// # Errors
/// [`CheckpointError::Refused`] for a file that is cut off, damaged, of another run, or none; those of the file system.
pub fn read_file<T: DeserializeOwned>(path: &Path, head: &Head) -> Result<T, CheckpointError> {
    let missing = || CheckpointError::Io {
        path: path.to_owned(),
        source: std::io::ErrorKind::NotFound.into(),
    };
    let (_, parts) = file::read(path, head)?
        .ok_or_else(missing)?
        .map_err(|refusal| CheckpointError::Refused(vec![refusal]))?;
    from_bytes(ONLY, parts.get(ONLY).map_or(&[], Vec::as_slice))
}

fn to_bytes<T: Serialize>(name: &str, part: &T) -> Result<Vec<u8>, CheckpointError> {
    postcard::to_stdvec(part)
        .map_err(|source| CheckpointError::Part { name: name.to_owned(), source })
}

fn from_bytes<T: DeserializeOwned>(name: &str, bytes: &[u8]) -> Result<T, CheckpointError> {
    postcard::from_bytes(bytes)
        .map_err(|source| CheckpointError::Part { name: name.to_owned(), source })
}
