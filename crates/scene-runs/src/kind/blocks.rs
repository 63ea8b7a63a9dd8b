//! An ensemble on the ranks of a job: blocks are distributed, stored in the result folder, and merged in order.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;

use mpi_ensembles::{BlockReport, Finished, Job, Ranks, Report, Store};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::inputs::Inputs;
use super::kind_run::Run;
use super::run_error::RunError;
use crate::causes::with_causes;
use crate::checkpoint::{CheckpointError, Head, Start, Survives, read_file, write_file};
use crate::output::write_json;

/// Largest number of blocks: enough to balance 10,000 ranks, few enough for one folder.
const MOST_BLOCKS: u64 = 65_536;

/// Folder of the blocks, inside the result folder.
const FOLDER: &str = "blocks";

/// Division of an ensemble into blocks. It depends on the ensemble alone, never on the ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// Number of items: paths, samples, realisations.
    pub n: u64,
    /// Smallest number of items in a block, except the last; a block is a multiple of it.
    pub unit: u64,
}

impl Cut {
    /// Number of blocks.
    #[must_use]
    pub fn n_blocks(self) -> u64 {
        self.n.div_ceil(self.length()).max(1)
    }

    /// Number of items in each block, except the last.
    fn length(self) -> u64 {
        let units = self.n.div_ceil(self.unit);
        units.div_ceil(MOST_BLOCKS).max(1) * self.unit
    }

    /// Range of items in a block.
    #[must_use]
    pub fn range(self, block: u64) -> Range<u64> {
        let bound = |k: u64| k.saturating_mul(self.length()).min(self.n);
        bound(block)..bound(block + 1)
    }
}

/// An unknown file in the folder of the blocks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} is not a block of this run, which has {n_blocks} blocks", .path.display())]
struct UnknownFile {
    path: PathBuf,
    n_blocks: u64,
}

/// The block number in a file differs from its name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} contains block {found}; by its name it is block {expected}", .path.display())]
struct OtherBlock {
    path: PathBuf,
    found: u64,
    expected: u64,
}

/// Files of the blocks of a run.
struct Files {
    folder: PathBuf,
    head: Head,
    n_blocks: u64,
}

impl Files {
    fn path(&self, block: u64) -> PathBuf {
        let width = self.n_blocks.to_string().len();
        self.folder.join(format!("block-{:0width$}-of-{}.bin", block + 1, self.n_blocks))
    }

    /// Lists the folder.
    fn found(&self) -> Result<Vec<PathBuf>, CheckpointError> {
        let io = |source| CheckpointError::Io { path: self.folder.clone(), source };
        if !self.folder.exists() {
            return Ok(Vec::new());
        }
        let mut files = Vec::new();
        for entry in std::fs::read_dir(&self.folder).map_err(io)? {
            let path = entry.map_err(io)?.path();
            if path.extension().is_some_and(|extension| extension == "bin") {
                files.push(path);
            }
        }
        files.sort();
        Ok(files)
    }

    /// Prepares the folder for a run with this start mode.
    fn open(&self, start: Start) -> Result<(), RunError> {
        let found = self.found()?;
        match start {
            Start::Anew if found.is_empty() => Ok(()),
            Start::Anew => {
                let (folder, found) = (self.folder.clone(), found.len());
                Err(RunError::BlocksLeft { folder, found })
            }
            Start::Overwrite => {
                let remove = |path: PathBuf| {
                    std::fs::remove_file(&path)
                        .map_err(|source| CheckpointError::Io { path, source }.into())
                };
                found.into_iter().try_for_each(remove)
            }
            Start::GoOn => {
                let names: BTreeSet<PathBuf> = (0..self.n_blocks).map(|k| self.path(k)).collect();
                match found.into_iter().find(|path| !names.contains(path)) {
                    Some(path) => {
                        Err(RunError::solver(UnknownFile { path, n_blocks: self.n_blocks }))
                    }
                    None => Ok(()),
                }
            }
        }
    }
}

impl<T: Serialize + DeserializeOwned> Store<T> for Files {
    fn load(&mut self, block: u64) -> Result<Option<T>, Box<dyn Error + Send + Sync>> {
        let path = self.path(block);
        if !path.exists() {
            return Ok(None);
        }
        let (found, part): (u64, T) = read_file(&path, &self.head)?;
        if found == block {
            Ok(Some(part))
        } else {
            Err(OtherBlock { path, found: found + 1, expected: block + 1 }.into())
        }
    }

    fn keep(&mut self, block: u64, part: &T) -> Result<(), Box<dyn Error + Send + Sync>> {
        Ok(write_file(&self.path(block), &self.head, &(block, part), Survives::Process)?)
    }
}

/// `job.json`: rank and time of each block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JobRecord {
    /// `job/1`.
    pub schema: String,
    /// Number of ranks.
    pub ranks: usize,
    /// Number of blocks stored by earlier runs.
    pub known: u64,
    /// Elapsed time on rank 0, from the start of the first block to the end of the last (s).
    pub seconds: f64,
    /// Fraction of the time of all ranks spent on blocks.
    pub efficiency: f64,
    /// The blocks in the order of arrival.
    pub blocks: Vec<BlockRecord>,
}

/// A computed block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockRecord {
    /// Its number, from 1, as in the name of its file.
    pub block: u64,
    /// The rank that computed it.
    pub rank: usize,
    /// Elapsed time (s).
    pub seconds: f64,
    /// Length of the message with its result; 0 on rank 0.
    pub bytes: usize,
    /// Time that rank 0 spent reading and storing it (s).
    pub taking: f64,
}

impl JobRecord {
    fn new(report: &Report) -> Self {
        let block = |it: &BlockReport| BlockRecord {
            block: it.block + 1,
            rank: it.rank,
            seconds: it.seconds,
            bytes: it.bytes,
            taking: it.taking,
        };
        Self {
            schema: "job/1".to_owned(),
            ranks: report.n_ranks,
            known: report.n_known,
            seconds: report.seconds,
            efficiency: report.efficiency(),
            blocks: report.blocks.iter().map(block).collect(),
        }
    }
}

impl Run<'_> {
    /// Ranks of the job of this process; `None` for a single process.
    #[must_use]
    pub fn ranks(&self) -> Option<&dyn Ranks> {
        self.ranks
    }

    /// Results of the blocks of an ensemble in order, computed by the ranks or loaded from the folder.
    ///
    /// `None` on ranks without the result. `words` formats the current estimate.
    ///
    /// # Errors
    /// [`RunError::Job`] with rank and block if a block fails; [`RunError::BlocksLeft`] if a run would restart over
    /// other blocks.
    pub fn on_ranks<T: Serialize + DeserializeOwned + Send>(
        &self,
        ranks: &dyn Ranks,
        inputs: &Inputs<'_, impl Serialize>,
        n_blocks: u64,
        compute: &(dyn Fn(u64) -> Result<T, RunError> + Sync),
        words: &dyn Fn(&mut dyn Iterator<Item = &T>) -> String,
    ) -> Result<Option<Vec<T>>, RunError> {
        let head = self.block_head(inputs)?;
        let job = Job { n_blocks, identity: head.fields() };
        let mut files = Files { folder: self.options.out.join(FOLDER), head, n_blocks };
        if ranks.rank() == 0 {
            files.open(self.options.start)?;
        }
        let compute = |block| compute(block).map_err(|error| with_causes(&error));
        let mut look = |parts: &BTreeMap<u64, T>| {
            self.progress.at((parts.len() as u64, n_blocks), || words(&mut parts.values()));
        };
        let Some(Finished { parts, report }) = job.run(ranks, compute, &mut files, &mut look)?
        else {
            return Ok(None);
        };
        write_json(&self.options.out.join("job.json"), &JobRecord::new(&report))?;
        Ok(Some(parts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_everything_once_and_are_whole_units() {
        for (n, unit) in [(1, 1), (7, 4), (100_000, 1), (1_000_003, 8), (65_537, 1)] {
            let cut = Cut { n, unit };
            let ranges: Vec<_> = (0..cut.n_blocks()).map(|block| cut.range(block)).collect();
            assert!(ranges.len() as u64 <= MOST_BLOCKS);
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, n));
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert!(ranges.iter().all(|range| range.start < range.end && range.start % unit == 0));
        }
    }
}
