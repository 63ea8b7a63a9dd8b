//! Exceedance probabilities of a density scene by guided paths or subset simulation.

use random_vibration::{
    ExceedanceQuestion, GuidedConfig, GuidedPaths, Linearisation, SubsetConfig, TailPaths, Tails,
};
use scene_runs::answers::Unknown;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Computed, Inputs, Run, RunError};
use sde_integrators::GaussianMixture;

use super::linearised::order;
use super::observed::Observed;
use super::probabilities::{Probabilities, UNGUIDED};
use super::record::{Content, Probability, Quantity, Series};
use super::step_bias::StepBias;
use crate::density::Requested;
use crate::monte_carlo::Sampling;
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

/// Paths for which the bias of the steps is measured: the number of pairs is a part of it.
const PATHS_OF_BIAS: u64 = 80_000;

/// Why the scatter of subset simulation is unknown: see `sde_integrators::subset_simulation`.
const FEW_SAMPLES: &str = "a run did not reach the event, or a level has fewer than 30 samples for each power of ten: take more samples";

/// Steps of the linearisation that guides the paths, per period.
const STEPS_OF_GUIDE: f64 = 20.0;

/// Creates the paths to a time in a number of steps; all other code is compiled once for each number of states.
type PathsTo<'s, const D: usize> =
    &'s dyn Fn(&GaussianMixture<D>, (f64, usize), [f64; D]) -> Result<TailPaths<'s, D>, PathsError>;

impl Visitor for TailsOf<'_> {
    type Output = Result<Computed<Content>, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let law = self.scene.initial_law::<D>(self.system)?;
        let asked = self.scene.requested::<D>(self.system, false)?;
        let sampling = Sampling { paths: PATHS_OF_BIAS, step: self.step, seed: self.seed };
        let bias = StepBias::measured((system, self.system.is_linear()), &law, &sampling, &asked);
        let found = match self.how {
            Estimator::Guided { samples } => {
                let order = order(self.system.kinks());
                let period = self.scene.reference_period(self.system.reference_period());
                let step = period / STEPS_OF_GUIDE;
                let rule = Linearisation { order, step };
                self.guided::<D>(samples, &|law, span, weights| {
                    let paths = system.guided(law, span, &rule)?;
                    Ok(paths.with_demand(weights)?)
                })
            }
            Estimator::Subset { config } => self.subset::<D>(&config, &|law, span, weights| {
                Ok(system.tails(law, span)?.with_demand(weights))
            }),
        }?;
        Ok(found.map(|mut content| {
            for Series { of, values, .. } in &mut content.quantities {
                let Quantity::Probability { threshold, .. } = *of else { continue };
                for observed in values {
                    bias.add_to_probability(threshold, observed);
                }
            }
            content.unknown.extend(bias.unknown());
            content
        }))
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
    ) -> Result<Computed<Content>, RunError> {
        let Self { scene, system: named, run, step, seed, how } = self;
        let inputs = &Inputs { scene, seed: Some(seed), files: &[] };
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        let (times, thresholds) = (&asked.times, &asked.thresholds[..]);
        let each = steps(scene.times.every, step);
        let n_steps: Vec<usize> = (1..=times.len()).map(|k| k * each).collect();
        let until = times.last().copied().unwrap_or_default();
        run.progress.stage(how.name());
        let clock = CpuClock::start();
        let paths = paths_to(&law, (until, times.len() * each), &asked.demand.weights)?;
        let n_paths = samples.saturating_mul(thresholds.len() as u64);
        let n_pilots = (samples / 4).max(200);
        let config = GuidedConfig { n_paths, n_pilots, unguided: UNGUIDED, seed };
        let tails = Tails::Both;
        let question = ExceedanceQuestion { thresholds, n_steps: &n_steps, tails, smallest: 0.0 };
        let study = paths.exceedance_study(&question, &config).map_err(RunError::solver)?;
        let found =
            probabilities(scene, how, &asked).guided((run, inputs), &study, clock.seconds())?;
        Ok(found.map(|found| found.content(&format!("|{}|", asked.demand.name), seed)))
    }

    /// Each time and threshold by subset simulation.
    fn subset<const D: usize>(
        self,
        config: &SubsetConfig,
        paths_to: PathsTo<'_, D>,
    ) -> Result<Computed<Content>, RunError> {
        let Self { scene, system: named, run, step, seed, how } = self;
        run.no_shards()?;
        // A method without a checkpoint still refuses to start over another run.
        run.checkpoint(&Inputs { scene, seed: Some(seed), files: &[] }, &["/title"])?;
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        let weights = std::array::from_fn(|k| asked.demand.weights[k]);
        let mut found = probabilities(scene, how, &asked);
        run.progress.stage(how.name());
        let (clock, mut path_steps) = (CpuClock::start(), 0);
        // Steps end at each observation, as those of the pairs of paths that show their bias.
        let each = steps(scene.times.every, step);
        for (row, &t) in asked.times.iter().enumerate() {
            let n_steps = (row + 1) * each;
            let paths = paths_to(&law, (t, n_steps), weights)?;
            for (k, &threshold) in asked.thresholds.iter().enumerate() {
                let estimate = paths.subset(threshold, config, seed);
                let observed =
                    estimate.map(|it| Observed::of_estimate(t, &it).unknown_for(FEW_SAMPLES));
                found.push((k, t), observed)?;
            }
            path_steps += paths.n_followed() * n_steps as u64;
            let done = (row as u64 + 1, asked.times.len() as u64);
            run.progress.at(done, || format!("t = {t:.4}"));
        }
        (found.work.path_steps, found.work.cpu_seconds) = (Some(path_steps), clock.seconds());
        Ok(Computed::Here(found.content(&format!("|{}|", asked.demand.name), seed)))
    }
}

/// No probability yet; moments are unknown.
fn probabilities<'a, const D: usize>(
    scene: &FpkScene,
    how: Estimator,
    asked: &'a Requested<D>,
) -> Probabilities<'a> {
    let mut found = Probabilities::new(Probability::Exceedance, &asked.times, &asked.thresholds);
    if !scene.moments.is_empty() {
        let reason =
            format!("the method ({}) estimates exceedance probabilities alone", how.name());
        found.unknown.push(Unknown { what: "all moments".to_owned(), reason });
    }
    found
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
