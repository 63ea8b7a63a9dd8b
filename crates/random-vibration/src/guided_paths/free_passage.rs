//! First passages by paths without a guide: crude Monte Carlo.

use std::ops::Range;

use sde_integrators::{Estimate, PairwiseSde, Passages, WongZakai};

use crate::guided_paths::guided_config::GuidedConfig;
use crate::guided_paths::guided_passage::PassageQuestion;
use crate::guided_paths::guided_study::{StudySet, StudySets};
use crate::guided_paths::path_runner::{PathBlock, PathRunner, check_span};
use crate::guided_paths::weights::Contributions;
use crate::guides::backward::Start;
use crate::guides::regression::RunningLaw;
use crate::tail::TailError;

/// First passages of a system of any number of states by free paths from rest: crude Monte Carlo.
///
/// Paths, responses and steps are those of [`GuidedPaths::from_rest`](crate::GuidedPaths::from_rest), and so are the blocks
/// that may run apart. Nothing is linearised.
pub struct FreePassages<'q> {
    runner: PathRunner<'q>,
    question: PassageQuestion<'q>,
    n_paths: u64,
    seed: u64,
}

impl<'q> FreePassages<'q> {
    /// Paths to a time in a number of steps.
    ///
    /// # Errors
    /// [`TailError::Sampling`], as for [`GuidedPaths::first_passages`](crate::GuidedPaths::first_passages).
    pub fn new<S: PairwiseSde>(
        system: &'q S,
        span: (f64, usize),
        question: &PassageQuestion<'q>,
        (n_paths, seed): (u64, u64),
    ) -> Result<Self, TailError> {
        check_span(span)?;
        GuidedConfig { n_paths, n_pilots: 0, unguided: 0.0, seed }.check(question.thresholds)?;
        question.check(system.n_states(), span.1)?;
        let start = Start::of(RunningLaw::at_rest(system.n_states()));
        let runner = PathRunner::new::<_, 1>(WongZakai(system), start, span);
        Ok(Self { runner, question: *question, n_paths, seed })
    }

    /// Number of blocks of paths.
    #[must_use]
    pub fn n_blocks(&self) -> u64 {
        self.sets().n_blocks()
    }

    /// Steps of all paths.
    #[must_use]
    pub fn path_steps(&self) -> u64 {
        self.sets().path_steps()
    }

    /// Runs some of the blocks, numbered from 0.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for a block that does not exist, and for a failed path, always the lowest.
    pub fn blocks(&self, blocks: Range<u64>) -> Result<Vec<PathBlock>, TailError> {
        Ok(self.sets().blocks(blocks)?)
    }

    /// The estimates from all blocks, in order: per time and threshold.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for blocks that are not those of these paths.
    pub fn estimates(&self, blocks: &[PathBlock]) -> Result<Vec<Vec<Estimate>>, TailError> {
        let sums = self.sets().sums(blocks)?;
        let row = |row: &[Contributions]| -> Result<Vec<Estimate>, TailError> {
            row.iter().map(|sum| Ok(Estimate::probability(sum.hits(), self.n_paths)?)).collect()
        };
        sums.chunks(self.question.thresholds.len()).map(row).collect()
    }

    fn sets(&self) -> StudySets<'_> {
        let PassageQuestion { responses, thresholds, n_steps } = self.question;
        let set = StudySet {
            guides: Vec::new(),
            passages: Some(Passages { responses, levels: thresholds }),
            n_steps: n_steps.last().copied().unwrap_or_default(),
            events: self.question.events(),
        };
        let Self { ref runner, n_paths, seed, .. } = *self;
        StudySets { runner, all: vec![set], n_paths, seed }
    }
}

/// The probabilities of [`FreePassages`], per time and threshold.
///
/// # Errors
/// Those of [`FreePassages::new`] and of a failed path.
pub fn free_passages<S: PairwiseSde>(
    system: &S,
    span: (f64, usize),
    question: &PassageQuestion<'_>,
    (n_paths, seed): (u64, u64),
) -> Result<Vec<Vec<Estimate>>, TailError> {
    let passages = FreePassages::new(system, span, question, (n_paths, seed))?;
    passages.estimates(&passages.blocks(0..passages.n_blocks())?)
}

impl std::fmt::Debug for FreePassages<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { question, n_paths, seed, .. } = self;
        f.debug_struct("FreePassages")
            .field("question", question)
            .field("n_paths", n_paths)
            .field("seed", seed)
            .finish_non_exhaustive()
    }
}
