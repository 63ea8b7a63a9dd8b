//! Guided paths with their guides chosen: blocks of paths that may run apart, and the estimates from all of them.

use std::ops::Range;

use sde_integrators::{Error, Guide, Passages, reduce_in_tree};

use crate::guided_paths::event::Event;
use crate::guided_paths::path_runner::{PathBlock, PathRunner, PathSet, block_lengths, n_blocks};
use crate::guided_paths::weights::{Contributions, GuidedEstimate, merge_sums};
use crate::tail::TailError;

/// Per time, per threshold: the estimate, or why its weights cannot be trusted.
pub type GuidedEstimates = Vec<Vec<Result<GuidedEstimate, TailError>>>;

/// Guided paths towards some events, whose guides are chosen.
///
/// Its paths come in [`n_blocks`](Self::n_blocks) blocks, whose number depends on the number of paths alone. Blocks may be
/// computed in any parts, also by other processes that make the same study; [`estimates`](Self::estimates) of all blocks
/// are bitwise those of one run. Making a study runs its pilot paths.
#[derive(Debug)]
pub struct GuidedStudy<'q> {
    pub(crate) sets: StudySets<'q>,
    /// Per event of all sets: its threshold, and the strength of the guides to it.
    pub(crate) thresholds: Vec<(f64, f64)>,
    /// Number of thresholds.
    pub(crate) n_thresholds: usize,
    /// Steps of all pilot paths.
    pub(crate) pilot_steps: u64,
}

/// One set of paths of a study, and its events.
#[derive(Debug)]
pub(crate) struct StudySet<'q> {
    pub(crate) guides: Vec<Guide>,
    pub(crate) passages: Option<Passages<'q>>,
    pub(crate) n_steps: usize,
    pub(crate) events: Vec<Event<'q>>,
}

/// Sets of equally many paths.
#[derive(Debug)]
pub(crate) struct StudySets<'q> {
    pub(crate) runner: &'q PathRunner<'q>,
    pub(crate) all: Vec<StudySet<'q>>,
    pub(crate) n_paths: u64,
    pub(crate) seed: u64,
}

impl GuidedStudy<'_> {
    /// Number of blocks of paths.
    #[must_use]
    pub fn n_blocks(&self) -> u64 {
        self.sets.n_blocks()
    }

    /// Steps of all paths, those of pilot paths included.
    #[must_use]
    pub fn path_steps(&self) -> u64 {
        self.sets.path_steps().saturating_add(self.pilot_steps)
    }

    /// Runs some of the blocks, numbered from 0.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for a block that does not exist, and for a failed path, always the lowest.
    pub fn blocks(&self, blocks: Range<u64>) -> Result<Vec<PathBlock>, TailError> {
        Ok(self.sets.blocks(blocks)?)
    }

    /// The estimates from all blocks, in order.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for blocks that are not those of this study.
    pub fn estimates(&self, blocks: &[PathBlock]) -> Result<GuidedEstimates, TailError> {
        let sums = self.sets.sums(blocks)?;
        let estimates = sums.iter().zip(&self.thresholds);
        let all: Vec<_> = estimates
            .map(|(sum, &(threshold, strength))| sum.estimate(threshold, strength))
            .collect();
        let mut all = all.into_iter();
        let n_times = sums.len() / self.n_thresholds.max(1);
        Ok((0..n_times).map(|_| all.by_ref().take(self.n_thresholds).collect()).collect())
    }

    /// Runs all blocks and returns the estimates.
    pub(crate) fn run(&self) -> Result<GuidedEstimates, TailError> {
        self.estimates(&self.blocks(0..self.n_blocks())?)
    }
}

impl StudySets<'_> {
    pub(crate) fn n_blocks(&self) -> u64 {
        self.all.len() as u64 * n_blocks(self.n_paths)
    }

    pub(crate) fn path_steps(&self) -> u64 {
        let steps = self.all.iter().map(|set| set.n_steps as u64).sum::<u64>();
        self.n_paths.saturating_mul(steps)
    }

    /// Runs some of the blocks of all sets, set by set.
    pub(crate) fn blocks(&self, blocks: Range<u64>) -> Result<Vec<PathBlock>, Error> {
        let limit = self.n_blocks();
        if blocks.end > limit {
            let (quantity, value) = ("block of guided paths", blocks.end as f64);
            return Err(Error::OutOfRange { quantity, value, from: 0.0, to: limit as f64 });
        }
        let each = n_blocks(self.n_paths);
        let mut found = Vec::new();
        for (set, first) in self.all.iter().zip((0..).step_by(usize::try_from(each).unwrap_or(1))) {
            let within =
                blocks.start.clamp(first, first + each)..blocks.end.clamp(first, first + each);
            if within.is_empty() {
                continue;
            }
            let StudySet { ref guides, passages, n_steps, ref events } = *set;
            let realisations = (0, self.n_paths);
            let paths = PathSet { guides, passages, seed: self.seed, n_steps, realisations };
            let within = within.start - first..within.end - first;
            found.extend(self.runner.blocks(&paths, within, events)?);
        }
        Ok(found)
    }

    /// Sums over all blocks: one for each event of each set.
    pub(crate) fn sums(&self, blocks: &[PathBlock]) -> Result<Vec<Contributions>, Error> {
        let wrong = |quantity, value, expected| Error::WrongLength { quantity, value, expected };
        let each = blocks.len() / self.all.len().max(1);
        if blocks.len() as u64 != self.n_blocks() {
            let expected = usize::try_from(self.n_blocks()).unwrap_or(usize::MAX);
            return Err(wrong("blocks of guided paths", blocks.len(), expected));
        }
        let mut all = Vec::new();
        for (set, blocks) in self.all.iter().zip(blocks.chunks(each.max(1))) {
            let expected = set.events.len();
            if let Some(other) = blocks.iter().find(|block| block.sums.len() != expected) {
                return Err(wrong("sums of a block of guided paths", other.sums.len(), expected));
            }
            for (block, expected) in blocks.iter().zip(block_lengths(self.n_paths)) {
                if let Some(other) = block.sums.iter().find(|sum| !sum.is_of(expected)) {
                    let length = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
                    let (value, expected) = (length(other.count()), length(expected));
                    return Err(wrong("paths in a block of guided paths", value, expected));
                }
            }
            let own = |block: &PathBlock| block.sums.clone();
            let sums = reduce_in_tree(blocks, &own, &merge_sums).unwrap_or_default();
            all.extend(sums);
        }
        Ok(all)
    }
}
