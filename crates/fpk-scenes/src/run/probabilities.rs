//! Probabilities over time by guided paths, free paths or subset simulation.

use std::ops::Range;

use random_vibration::{GuidedStudy, PathBlock, TailError};
use scene_runs::answers::Unknown;
use scene_runs::kind::{Computed, Ensemble, Inputs, Items, Run, RunError};
use sde_integrators::Error;
use serde::Serialize;

use super::observed::Observed;
use super::record::{Content, Probability, Quantity, Series, WorkRecord};
use super::step_bias::StepBias;

/// Share of guided paths without a guide.
pub(crate) const UNGUIDED: f64 = 0.05;
/// Blocks for each thread between two looks at the checkpoint.
const BLOCKS_OF_THREAD: u64 = 4;

/// Probabilities so far, and those that have no estimate.
pub(crate) struct Probabilities<'a> {
    pub(crate) by: Probability,
    pub(crate) times: &'a [f64],
    pub(crate) thresholds: &'a [f64],
    /// Threshold by threshold.
    values: Vec<Vec<Observed>>,
    pub(crate) unknown: Vec<Unknown>,
    pub(crate) work: WorkRecord,
}

impl<'a> Probabilities<'a> {
    /// No probability yet.
    pub(crate) fn new(by: Probability, times: &'a [f64], thresholds: &'a [f64]) -> Self {
        let values = vec![Vec::new(); thresholds.len()];
        Self { by, times, thresholds, values, unknown: Vec::new(), work: WorkRecord::default() }
    }

    /// Adds a probability by the index of its threshold and its time, or the reason why it is unknown.
    pub(crate) fn push(
        &mut self,
        (k, t): (usize, f64),
        found: Result<Observed, TailError>,
    ) -> Result<(), RunError> {
        match found {
            Ok(observed) => self.values[k].push(observed),
            Err(
                error @ (TailError::Untrusted { .. }
                | TailError::Sampling(Error::TooManyLevels { .. })),
            ) => self.unknown.push(Unknown {
                what: format!(
                    "{} at t = {t}",
                    Quantity::Probability { by: self.by, threshold: self.thresholds[k] }
                ),
                reason: error.to_string(),
            }),
            Err(error) => return Err(RunError::solver(error)),
        }
        Ok(())
    }

    /// Adds a row of estimates for each time.
    fn extend<T>(
        &mut self,
        rows: Vec<Vec<T>>,
        observed: impl Fn(f64, T) -> Result<Observed, TailError>,
    ) -> Result<(), RunError> {
        for (&t, row) in self.times.iter().zip(rows) {
            for (k, estimate) in row.into_iter().enumerate() {
                self.push((k, t), observed(t, estimate))?;
            }
        }
        Ok(())
    }

    /// Adds the estimates of guided paths, whose plan took some CPU time (s).
    pub(crate) fn guided(
        self,
        run: (&Run<'_>, &Inputs<'_, impl Serialize>),
        study: &GuidedStudy<'_>,
        cpu_seconds: f64,
    ) -> Result<Computed<Self>, RunError> {
        let compute = |blocks| study.blocks(blocks);
        let estimates = |blocks: &[PathBlock]| study.estimates(blocks);
        let observed =
            |t, found: Result<_, TailError>| found.map(|found| Observed::of_guided(t, &found));
        let found = self.by_blocks(run, (study.n_blocks(), &compute), estimates, observed)?;
        Ok(found.map(|mut found| {
            found.work.path_steps = Some(study.path_steps());
            found.work.cpu_seconds += cpu_seconds;
            found
        }))
    }

    /// Adds estimates from blocks of paths that any process may compute.
    pub(crate) fn by_blocks<T>(
        mut self,
        (run, inputs): (&Run<'_>, &Inputs<'_, impl Serialize>),
        (n_blocks, compute): (u64, &Compute<'_>),
        estimates: impl FnOnce(&[PathBlock]) -> Result<Vec<Vec<T>>, TailError>,
        observed: impl Fn(f64, T) -> Result<Observed, TailError>,
    ) -> Result<Computed<Self>, RunError> {
        let ensemble = Ensemble {
            what: "blocks of paths",
            n: n_blocks,
            n_on_ranks: n_blocks,
            at_once: BLOCKS_OF_THREAD * rayon::current_num_threads() as u64,
            compute: &|blocks, _| compute(blocks).map_err(RunError::solver),
            words: &|_| "blocks of paths".to_owned(),
        };
        Ok(match run.ensemble(inputs, &ensemble)? {
            Computed::Here(Items { list, cpu_seconds }) => {
                self.work.cpu_seconds = cpu_seconds;
                self.extend(estimates(&list).map_err(RunError::solver)?, observed)?;
                Computed::Here(self)
            }
            Computed::Elsewhere(files) => Computed::Elsewhere(files),
        })
    }

    /// Adds the bias of the steps to the errors.
    pub(crate) fn add_bias(&mut self, bias: &StepBias) {
        for (&threshold, values) in self.thresholds.iter().zip(&mut self.values) {
            for observed in values {
                bias.add_to_probability(threshold, observed);
            }
        }
        self.unknown.extend(bias.unknown());
    }

    /// The result for a demand in words; thresholds without a value are omitted.
    pub(crate) fn content(mut self, demand: &str, seed: u64) -> Content {
        let values = std::mem::take(&mut self.values).into_iter().enumerate();
        let series = values
            .filter(|(_, values)| !values.is_empty())
            .map(|(k, values)| Series::probability((self.by, self.thresholds[k]), demand, values));
        let quantities = series.collect();
        let Self { work, unknown, .. } = self;
        Content { seed: Some(seed), work, stopped: None, unknown, quantities }
    }
}

/// Computes a range of blocks of paths.
type Compute<'a> = dyn Fn(Range<u64>) -> Result<Vec<PathBlock>, TailError> + Sync + 'a;
