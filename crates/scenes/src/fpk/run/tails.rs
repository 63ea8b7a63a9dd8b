//! Exceedance probabilities of a density scene by importance sampling or subset simulation, each estimated separately.

use random_vibration::{Estimate, SubsetConfig, TailError, TailPaths, Tails};
use sde_integrators::{Error, GaussianMixture};

use super::asked::{asked, law};
use super::observed::Observed;
use super::outcome::Outcome;
use super::record::{WorkRecord, asked_series};
use crate::clock::CpuClock;
use crate::fpk::integrator_scene::IntegratorScene;
use crate::fpk::paths::{Paths, PathsError};
use crate::fpk::scene::FpkScene;
use crate::fpk::system::{System, Visitor};
use crate::kind::{Run, RunError};
use crate::run_result::Unknown;

/// Solves the exceedances of a scene.
pub(super) struct TailsOf<'a> {
    pub(super) scene: &'a FpkScene,
    pub(super) system: &'a System,
    pub(super) run: &'a Run<'a>,
    /// Longest step.
    pub(super) step: f64,
    pub(super) integrator: IntegratorScene,
    pub(super) seed: u64,
    pub(super) how: Estimator,
}

/// Estimator of one probability.
#[derive(Debug, Clone, Copy)]
pub(super) enum Estimator {
    /// Importance sampling of both tails.
    Importance { samples: u64 },
    /// Subset simulation.
    Subset { config: SubsetConfig },
}

impl Estimator {
    const fn name(self) -> &'static str {
        match self {
            Self::Importance { .. } => "importance sampling",
            Self::Subset { .. } => "subset simulation",
        }
    }

    fn estimate<const D: usize>(
        self,
        paths: &TailPaths<'_, D>,
        threshold: f64,
        seed: u64,
    ) -> Result<Estimate, TailError> {
        match self {
            Self::Importance { samples } => paths.importance(threshold, Tails::Both, samples, seed),
            Self::Subset { config } => paths.subset(threshold, &config, seed),
        }
    }
}

/// Creates the paths to a time in a number of steps; all other code is compiled once for each number of states.
type PathsTo<'s, const D: usize> =
    &'s dyn Fn(&GaussianMixture<D>, (f64, usize)) -> Result<TailPaths<'s, D>, PathsError>;

impl Visitor for TailsOf<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let integrator = self.integrator;
        self.tails::<D>(&|law, span| system.tails(integrator, law, span))
    }
}

impl TailsOf<'_> {
    fn tails<const D: usize>(self, paths_to: PathsTo<'_, D>) -> Result<Outcome, RunError> {
        let Self { scene, system: named, run, step, seed, how, .. } = self;
        let (law, asked) = (law::<D>(scene, named)?, asked::<D>(scene, named, false)?);
        let weights = std::array::from_fn(|k| asked.demand.weights[k]);
        let (mut values, mut unknown) = (vec![Vec::new(); asked.thresholds.len()], Vec::new());
        if !scene.moments.is_empty() {
            let reason = format!("{} estimates exceedance probabilities alone", how.name());
            unknown.push(Unknown { what: "all moments".to_owned(), reason });
        }
        run.progress.stage(how.name());
        let (clock, mut path_steps) = (CpuClock::start(), 0);
        for (row, &t) in asked.times.iter().enumerate() {
            let n_steps = steps(t, step);
            let paths = paths_to(&law, (t, n_steps))?.with_demand(weights);
            for (values, &threshold) in values.iter_mut().zip(&asked.thresholds) {
                match how.estimate(&paths, threshold, seed) {
                    Ok(estimate) => values.push((t, estimate)),
                    Err(TailError::Sampling(
                        error @ (Error::NoDesignPoint { .. } | Error::TooManyLevels { .. }),
                    )) => unknown.push(Unknown {
                        what: format!("exceedance/{threshold} at t = {t}"),
                        reason: error.to_string(),
                    }),
                    Err(error) => return Err(RunError::solver(error)),
                }
            }
            path_steps += paths.n_followed() * n_steps as u64;
            let done = (row as u64 + 1, asked.times.len() as u64);
            run.progress.at(done, || format!("t = {t:.4}"));
        }
        let exceedance = |k: usize| {
            let observed = |(t, estimate): &(f64, Estimate)| Observed::of_estimate(*t, estimate);
            values[k].iter().map(observed).collect()
        };
        let quantities = asked_series(scene, named, &|_| Vec::new(), &exceedance);
        let (path_steps, cpu_seconds) = (Some(path_steps), clock.seconds());
        let work = WorkRecord { path_steps, cpu_seconds, ..WorkRecord::default() };
        Ok(Outcome { work, unknown, quantities, seed: Some(seed), ..Outcome::default() })
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
