//! Checkpoints of a run: an interrupted run resumes with bitwise identical results.
//!
//! Two files alternate in the folder of the results, so one of them is always complete. Each has a head that
//! identifies its run, and ends in a hash of the preceding bytes. A scene kind stores named parts in it. Parts stored
//! after the end of a run serve a longer run of the same scene.

mod error;
mod file;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use self::error::{CheckpointError, Reason, Refusal};
use self::file::{Content, Parts, Stage};
pub use self::file::{Head, Survives};
use crate::interrupt;

/// Minimum interval between two checkpoints, in multiples of the time to write one.
const LEAST_SHARE: u32 = 50;

/// How a run starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// From the beginning, unless the last checkpoint in its folder belongs to an unfinished run.
    Anew,
    /// From the beginning, whatever the folder contains.
    Overwrite,
    /// From the last checkpoint in its folder; from the beginning if there is none.
    GoOn,
}

/// Checkpoint of a run.
#[derive(Debug)]
pub struct Checkpoint {
    /// Where its files are; none of a run in memory, of which nothing is stored.
    files: Option<Files>,
    every: Duration,
    kept: Mutex<Stored>,
}

/// Place and identity of the files of a checkpoint.
#[derive(Debug)]
struct Files {
    folder: PathBuf,
    head: Head,
}

#[derive(Debug)]
struct Stored {
    parts: Parts,
    /// Number of files written by all runs into the folder.
    sequence: u64,
    stage: Stage,
    last: Instant,
    /// Time to write the last file.
    took: Duration,
}

/// Files found at the start.
#[derive(Debug)]
pub struct Found {
    /// The file from which the run resumes.
    pub file: Option<PathBuf>,
    /// Files that were rejected, with reasons.
    pub refused: Vec<Refusal>,
}

impl Checkpoint {
    /// The checkpoint of a run in memory: nothing is stored, and nothing is loaded.
    #[must_use]
    pub fn in_memory() -> Self {
        let kept = Mutex::new(Stored::new(Parts::new(), 0, Stage::Ended));
        Self { files: None, every: Duration::MAX, kept }
    }

    /// Opens the checkpoint of the run identified by `head`, in its result folder; `interval` limits its writes.
    ///
    /// # Errors
    /// [`CheckpointError::Refused`] if files exist but none can be resumed: truncated or damaged files, files of
    /// another scene, version or instruction set, and files that are no checkpoints. [`CheckpointError::Unfinished`]
    /// if a run would restart over an unfinished one. Errors of the file system.
    pub fn open(
        folder: &Path,
        head: Head,
        start: Start,
        every: Duration,
    ) -> Result<(Self, Found), CheckpointError> {
        let mut found = Found { file: None, refused: Vec::new() };
        let mut last: Option<(PathBuf, Content)> = None;
        for path in file::names(folder) {
            let Some(read) = file::read(&path)? else { continue };
            // A checkpoint that is not resumed may belong to any run.
            let read = if start == Start::GoOn { read.and_then(|it| it.of(&head)) } else { read };
            match read {
                Ok(content)
                    if last.as_ref().is_none_or(|(_, it)| it.sequence < content.sequence) =>
                {
                    last = Some((path, content));
                }
                Ok(_) => {}
                Err(reason) => found.refused.push(Refusal { path, reason }),
            }
        }
        let kept = match (start, last) {
            (Start::GoOn, None) if !found.refused.is_empty() => {
                return Err(CheckpointError::Refused(found.refused));
            }
            (Start::Anew, Some((path, Content { stage: Stage::UnderWay, .. }))) => {
                return Err(CheckpointError::Unfinished { path });
            }
            (Start::GoOn, Some((path, Content { sequence, stage, parts, .. }))) => {
                found.file = Some(path);
                Stored::new(parts, sequence, stage)
            }
            (Start::Anew | Start::Overwrite, last) => {
                // An unreadable file is no loss.
                found.refused.clear();
                let sequence = last.map_or(0, |(_, content)| content.sequence);
                Stored::new(Parts::new(), sequence, Stage::Ended)
            }
            (Start::GoOn, None) => Stored::new(Parts::new(), 0, Stage::Ended),
        };
        let files = Some(Files { folder: folder.to_owned(), head });
        Ok((Self { files, every, kept: Mutex::new(kept) }, found))
    }

    /// Loads a part stored by an earlier run.
    ///
    /// # Errors
    /// [`CheckpointError::Part`] for a part that is not a `T`.
    pub fn part<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, CheckpointError> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.parts.get(name).map(|bytes| from_bytes(name, bytes)).transpose()
    }

    /// Whether the interval since the last checkpoint has elapsed.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).is_due(self.every)
    }

    /// Stores a part, replacing any part of the same name, and writes the checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError::Part`] if the part cannot be serialised, [`CheckpointError::Interrupted`] once the checkpoint is written
    /// if a [signal](crate::interrupt) came, and errors of the file system.
    pub fn keep<T: Serialize>(&self, name: &str, part: &T) -> Result<(), CheckpointError> {
        self.store(name, part, |_| true)
    }

    /// Stores a part, replacing any part of the same name, for the next time that the checkpoint is written.
    ///
    /// # Errors
    /// [`CheckpointError::Part`] if the part cannot be serialised.
    pub fn put<T: Serialize>(&self, name: &str, part: &T) -> Result<(), CheckpointError> {
        self.store(name, part, |_| false)
    }

    /// Stores a part, replacing any part of the same name. The checkpoint is written if [due](Self::is_due), else with a later
    /// part or at the [end](Self::end): an interruption loses at most the interval.
    ///
    /// Use it for parts that come in quick succession, since every write writes all parts.
    ///
    /// # Errors
    /// As [`keep`](Self::keep).
    pub fn keep_if_due<T: Serialize>(&self, name: &str, part: &T) -> Result<(), CheckpointError> {
        self.store(name, part, |kept| kept.is_due(self.every))
    }

    fn store<T: Serialize>(
        &self,
        name: &str,
        part: &T,
        is_due: impl FnOnce(&Stored) -> bool,
    ) -> Result<(), CheckpointError> {
        let Some(files) = &self.files else {
            let is_requested = interrupt::is_requested();
            return if is_requested { Err(CheckpointError::NotKept) } else { Ok(()) };
        };
        let start = Instant::now();
        let bytes = to_bytes(name, part)?;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.parts.insert(name.to_owned(), bytes);
        kept.stage = Stage::UnderWay;
        if is_due(&kept) {
            files.write(&mut kept)?;
            kept.took = start.elapsed();
            if interrupt::is_requested() {
                return Err(CheckpointError::Interrupted { path: files.newest(&kept) });
            }
        }
        Ok(())
    }

    /// Marks the run as finished, so that another run may start from the beginning in its folder.
    ///
    /// Stored parts remain, for a longer run of the same scene.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn end(&self) -> Result<(), CheckpointError> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let (Some(files), Stage::UnderWay) = (&self.files, kept.stage) {
            kept.stage = Stage::Ended;
            files.write(&mut kept)?;
        }
        Ok(())
    }
}

impl Files {
    /// The file that was written last, or is being written.
    fn newest(&self, kept: &Stored) -> PathBuf {
        let [even, odd] = file::names(&self.folder);
        if kept.sequence.is_multiple_of(2) { even } else { odd }
    }

    /// Overwrites the older of the two files.
    fn write(&self, kept: &mut Stored) -> Result<(), CheckpointError> {
        kept.sequence += 1;
        let path = &self.newest(kept);
        let at = (kept.sequence, kept.stage);
        file::write(path, &self.head, at, &kept.parts, Survives::Machine)?;
        kept.last = Instant::now();
        Ok(())
    }
}

impl Stored {
    fn new(parts: Parts, sequence: u64, stage: Stage) -> Self {
        Self { parts, sequence, stage, last: Instant::now(), took: Duration::ZERO }
    }

    fn is_due(&self, every: Duration) -> bool {
        interrupt::is_requested() || self.last.elapsed() >= every.max(LEAST_SHARE * self.took)
    }
}

/// Name of the part in a file with a single part.
const ONLY: &str = "part";

/// Writes a file with one part, in the format of a checkpoint.
///
/// # Errors
/// As [`Checkpoint::keep`].
pub fn write_file<T: Serialize>(
    path: &Path,
    head: &Head,
    part: &T,
    survives: Survives,
) -> Result<(), CheckpointError> {
    let parts = Parts::from([(ONLY.to_owned(), to_bytes(ONLY, part)?)]);
    file::write(path, head, (1, Stage::Ended), &parts, survives)
}

/// Reads a file written by [`write_file`].
///
/// # Errors
/// [`CheckpointError::Refused`] for a file that is truncated, damaged, of another run, or no checkpoint; errors of the
/// file system.
pub fn read_file<T: DeserializeOwned>(path: &Path, head: &Head) -> Result<T, CheckpointError> {
    let missing = || CheckpointError::Io {
        path: path.to_owned(),
        source: std::io::ErrorKind::NotFound.into(),
    };
    let refusal = |reason| Refusal { path: path.to_owned(), reason };
    let content = file::read(path)?
        .ok_or_else(missing)?
        .and_then(|content| content.of(head))
        .map_err(|reason| CheckpointError::Refused(vec![refusal(reason)]))?;
    from_bytes(ONLY, content.parts.get(ONLY).map_or(&[], Vec::as_slice))
}

fn to_bytes<T: Serialize>(name: &str, part: &T) -> Result<Vec<u8>, CheckpointError> {
    postcard::to_stdvec(part)
        .map_err(|source| CheckpointError::Part { name: name.to_owned(), source })
}

fn from_bytes<T: DeserializeOwned>(name: &str, bytes: &[u8]) -> Result<T, CheckpointError> {
    postcard::from_bytes(bytes)
        .map_err(|source| CheckpointError::Part { name: name.to_owned(), source })
}
