//! What is kept of a run while it goes, so that it goes on to the same bits after it was killed.
//!
//! Two files take turns in the folder of the results, so that one of them is whole at any moment. Each has a head that says whose
//! it is, and ends in a hash of all that stands before. A kind of scene keeps parts in it, by name; what it keeps after the run has
//! ended serves a longer run of the same scene.

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
pub use self::file::Head;
use self::file::{Content, Parts, Stage, Survives};

/// Between two checkpoints lie at least so many times the time that writing one takes.
const LEAST_SHARE: u32 = 50;

/// How a run begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// From nothing, unless the last checkpoint in its folder is of a run that has not come to its end.
    Anew,
    /// From nothing, whatever is in its folder.
    Overwrite,
    /// From the last checkpoint in its folder; from nothing where there is none.
    GoOn,
}

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
    /// How many files were written, by all runs into the folder.
    sequence: u64,
    stage: Stage,
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
    /// another scene, version or instruction set, or is no checkpoint; [`CheckpointError::Unfinished`] where a run would start anew
    /// over one that has not come to its end; those of the file system.
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
            // What is not gone on from may be whosever it is.
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
                Kept::new(parts, sequence, stage)
            }
            (Start::Anew | Start::Overwrite, last) => {
                // A file that nothing can be read from is no loss.
                found.refused.clear();
                let sequence = last.map_or(0, |(_, content)| content.sequence);
                Kept::new(Parts::new(), sequence, Stage::Ended)
            }
            (Start::GoOn, None) => Kept::new(Parts::new(), 0, Stage::Ended),
        };
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
        kept.stage = Stage::UnderWay;
        self.write(&mut kept)?;
        kept.took = start.elapsed();
        Ok(())
    }

    /// Says that the results of the run are written, so that another may start anew in its folder. What was kept stays, for a longer
    /// run of the same scene.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn end(&self) -> Result<(), CheckpointError> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.stage == Stage::UnderWay {
            kept.stage = Stage::Ended;
            self.write(&mut kept)?;
        }
        Ok(())
    }

    /// Over the older of the two files.
    fn write(&self, kept: &mut Kept) -> Result<(), CheckpointError> {
        kept.sequence += 1;
        let path = &file::names(&self.folder)[usize::from(kept.sequence % 2 == 1)];
        let at = (kept.sequence, kept.stage);
        file::write(path, &self.head, at, &kept.parts, Survives::Machine)?;
        kept.last = Instant::now();
        Ok(())
    }
}

impl Kept {
    fn new(parts: Parts, sequence: u64, stage: Stage) -> Self {
        Self { parts, sequence, stage, last: Instant::now(), took: Duration::ZERO }
    }
}

/// What a file that holds one part calls it.
const ONLY: &str = "part";

/// Writes a file that holds one part, in the form of a checkpoint.
///
/// # Errors
/// As [`Checkpoint::keep`].
pub fn write_file<T: Serialize>(path: &Path, head: &Head, part: &T) -> Result<(), CheckpointError> {
    write_one(path, head, part, Survives::Machine)
}

/// The same for one of many that are soon made again: it does not wait for the disk, so that a machine that ends, but no process that is
/// killed, may leave it cut off.
///
/// # Errors
/// As [`Checkpoint::keep`].
pub fn write_block<T: Serialize>(
    path: &Path,
    head: &Head,
    part: &T,
) -> Result<(), CheckpointError> {
    write_one(path, head, part, Survives::Process)
}

fn write_one<T: Serialize>(
    path: &Path,
    head: &Head,
    part: &T,
    survives: Survives,
) -> Result<(), CheckpointError> {
    let parts = Parts::from([(ONLY.to_owned(), to_bytes(ONLY, part)?)]);
    file::write(path, head, (1, Stage::Ended), &parts, survives)
}

/// Reads what [`write_file`] or [`write_block`] has written.
///
/// # Errors
/// [`CheckpointError::Refused`] for a file that is cut off, damaged, of another run, or none; those of the file system.
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
