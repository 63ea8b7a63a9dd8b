//! Exceedance probabilities of a density scene by guided paths or subset simulation.

use random_vibration::{
    ExceedanceQuestion, GuidedConfig, GuidedPaths, Linearisation, SubsetConfig, TailError,
    TailPaths, Tails,
};
use scene_runs::answers::Unknown;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Computed, Inputs, Run, RunError};
use sde_integrators::{Error, GaussianMixture};

use super::linearised::order;
use super::observed::Observed;
use super::outcome::Outcome;
use super::record::{WorkRecord, asked_series};
use crate::path_blocks::path_blocks;
use crate::paths::{Paths, PathsError};
use crate::scene::FpkScene;
use crate::system::{System, Visitor};

/// Solves the exceedances of a scene.
pub(super) struct TailsOf<'a> {
    pub(super) scene: &'a FpkScene,
    pub(super) system: &'a System,
    pub(super) run: &'a Run<'a>,
    /// Longest step.
    pub(super) step: f64,
    pub(super) seed: u64,
    pub(super) how: Estimator,
}

/// Estimator of one probability.
#[derive(Debug, Clone, Copy)]
pub(super) enum Estimator {
    /// Guided paths to both tails.
    Guided { samples: u64 },
    /// Subset simulation.
    Subset { config: SubsetConfig },
}

impl Estimator {
    const fn name(self) -> &'static str {
        match self {
            Self::Guided { .. } => "guided paths",
            Self::Subset { .. } => "subset simulation",
        }
    }
}

/// Share of the paths without a guide.
const UNGUIDED: f64 = 0.05;
/// Steps of the linearisation that guides the paths, per period.
const STEPS_OF_GUIDE: f64 = 20.0;

/// Creates the paths to a time in a number of steps; all other code is compiled once for each number of states.
type PathsTo<'s, const D: usize> =
    &'s dyn Fn(&GaussianMixture<D>, (f64, usize), [f64; D]) -> Result<TailPaths<'s, D>, PathsError>;

impl Visitor for TailsOf<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let samples = match self.how {
            Estimator::Guided { samples } => samples,
            Estimator::Subset { config } => {
                return self.subset::<D>(&config, &|law, span, weights| {
                    Ok(system.tails(law, span)?.with_demand(weights))
                });
            }
        };
        let order = order(self.system.kinks());
        let rule = Linearisation { order, step: self.system.reference_period() / STEPS_OF_GUIDE };
        self.guided::<D>(samples, &|law, span, weights| {
            let paths = system.guided(law, span, &rule)?;
            Ok(paths.with_demand(weights)?)
        })
    }
}

/// Creates guided paths to a time in a number of steps; all other code is compiled once for each number of states.
type GuidedTo<'s, const D: usize> =
    &'s dyn Fn(&GaussianMixture<D>, (f64, usize), &[f64]) -> Result<GuidedPaths<'s>, PathsError>;

impl TailsOf<'_> {
    /// All times and thresholds by guided paths, whose blocks may run in any processes.
    fn guided<const D: usize>(
        self,
        samples: u64,
        paths_to: GuidedTo<'_, D>,
    ) -> Result<Outcome, RunError> {
        let Self { scene, system: named, run, step, seed, .. } = self;
        let inputs = &Inputs { scene, seed: Some(seed), files: &[] };
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        let (times, thresholds) = (&asked.times, &asked.thresholds[..]);
        let each = steps(scene.times.every, step);
        let n_steps: Vec<usize> = (1..=times.len()).map(|k| k * each).collect();
        let until = times.last().copied().unwrap_or_default();
        run.progress.stage(self.how.name());
        let clock = CpuClock::start();
        let paths = paths_to(&law, (until, times.len() * each), &asked.demand.weights)?;
        let n_paths = samples.saturating_mul(thresholds.len() as u64);
        let n_pilots = (samples / 4).max(200);
        let config = GuidedConfig { n_paths, n_pilots, unguided: UNGUIDED, seed };
        let tails = Tails::Both;
        let question = ExceedanceQuestion { thresholds, n_steps: &n_steps, tails, smallest: 0.0 };
        let study = paths.exceedance_study(&question, &config).map_err(RunError::solver)?;
        let of_setup = clock.seconds();
        let compute = |blocks| study.blocks(blocks);
        let blocks = match path_blocks(run, inputs, study.n_blocks(), &compute)? {
            Computed::Here(blocks) => blocks,
            Computed::Elsewhere(files) => {
                return Ok(Outcome { files, is_elsewhere: true, ..Outcome::default() });
            }
        };
        let mut probabilities = self.probabilities();
        let rows = study.estimates(&blocks.list).map_err(RunError::solver)?;
        for (&t, row) in times.iter().zip(rows) {
            for (k, found) in row.into_iter().enumerate() {
                probabilities.push((k, t), found.map(|found| Observed::of_guided(t, &found)))?;
            }
        }
        let cpu_seconds = of_setup + blocks.cpu_seconds;
        Ok(self.outcome(probabilities, (study.path_steps(), cpu_seconds)))
    }

    /// Each time and threshold by subset simulation.
    fn subset<const D: usize>(
        self,
        config: &SubsetConfig,
        paths_to: PathsTo<'_, D>,
    ) -> Result<Outcome, RunError> {
        let Self { scene, system: named, run, step, seed, how, .. } = self;
        run.no_shards()?;
        // A method without a checkpoint still refuses to start over another run.
        run.checkpoint(&Inputs { scene, seed: Some(seed), files: &[] }, &["/title"])?;
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        let weights = std::array::from_fn(|k| asked.demand.weights[k]);
        let mut probabilities = self.probabilities();
        run.progress.stage(how.name());
        let (clock, mut path_steps) = (CpuClock::start(), 0);
        for (row, &t) in asked.times.iter().enumerate() {
            let n_steps = steps(t, step);
            let paths = paths_to(&law, (t, n_steps), weights)?;
            for (k, &threshold) in asked.thresholds.iter().enumerate() {
                let found = paths.subset(threshold, config, seed);
                probabilities.push((k, t), found.map(|found| Observed::of_estimate(t, &found)))?;
            }
            path_steps += paths.n_followed() * n_steps as u64;
            let done = (row as u64 + 1, asked.times.len() as u64);
            run.progress.at(done, || format!("t = {t:.4}"));
        }
        Ok(self.outcome(probabilities, (path_steps, clock.seconds())))
    }

    /// No probability yet; moments are unknown.
    fn probabilities(&self) -> Probabilities<'_> {
        let Self { scene, how, .. } = self;
        let mut unknown = Vec::new();
        if !scene.moments.is_empty() {
            let reason =
                format!("the method ({}) estimates exceedance probabilities alone", how.name());
            unknown.push(Unknown { what: "all moments".to_owned(), reason });
        }
        let thresholds = &scene.thresholds[..];
        Probabilities { thresholds, values: vec![Vec::new(); thresholds.len()], unknown }
    }

    fn outcome(
        &self,
        probabilities: Probabilities<'_>,
        (path_steps, cpu_seconds): (u64, f64),
    ) -> Outcome {
        let Probabilities { values, unknown, .. } = probabilities;
        let exceedance = |k: usize| values[k].clone();
        let quantities = asked_series(self.scene, self.system, &|_| Vec::new(), &exceedance);
        let work =
            WorkRecord { path_steps: Some(path_steps), cpu_seconds, ..WorkRecord::default() };
        Outcome { work, unknown, quantities, seed: Some(self.seed), ..Outcome::default() }
    }
}

/// Probabilities over time, threshold by threshold.
struct Probabilities<'a> {
    thresholds: &'a [f64],
    values: Vec<Vec<Observed>>,
    unknown: Vec<Unknown>,
}

impl Probabilities<'_> {
    /// Adds a probability, or the reason why it is unknown.
    fn push(
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
                what: format!("exceedance/{} at t = {t}", self.thresholds[k]),
                reason: error.to_string(),
            }),
            Err(error) => return Err(RunError::solver(error)),
        }
        Ok(())
    }
}

/// Number of steps to a time, given the longest step; the tolerance prevents roundoff from adding one.
fn steps(t: f64, longest: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked: at most 1e5"
    )]
    let steps = (t / longest - 1e-9).ceil().max(1.0) as usize;
    steps
}
