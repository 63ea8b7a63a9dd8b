//! Exceedance probabilities of a density scene by guided paths, importance sampling or subset simulation, each estimated separately.

use std::cell::Cell;

use random_vibration::{
    GuidedConfig, GuidedPaths, Linearisation, SubsetConfig, TailError, TailPaths, Tails,
};
use sde_integrators::{Error, GaussianMixture};

use super::asked::{asked, law};
use super::linearised::order;
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
    /// Guided paths to both tails.
    Guided { samples: u64 },
    /// A method that takes a path as a function of its normals.
    Driven(Driven),
}

/// Method that takes a path as a function of its normals.
#[derive(Debug, Clone, Copy)]
pub(super) enum Driven {
    /// Importance sampling of both tails.
    Importance { samples: u64 },
    /// Subset simulation.
    Subset { config: SubsetConfig },
}

impl Estimator {
    const fn name(self) -> &'static str {
        match self {
            Self::Guided { .. } => "guided paths",
            Self::Driven(Driven::Importance { .. }) => "importance sampling",
            Self::Driven(Driven::Subset { .. }) => "subset simulation",
        }
    }
}

/// Share of the paths without a guide.
const UNGUIDED: f64 = 0.05;
/// Steps of the linearisation that guides the paths, per period.
const STEPS_OF_GUIDE: f64 = 20.0;

/// Estimates probabilities at one time.
trait AtTime {
    /// `P(|y| > T)` for a threshold at the time `t` of the paths.
    fn exceedance(&self, t: f64, threshold: f64) -> Result<Observed, TailError>;

    /// Number of paths evaluated so far.
    fn n_followed(&self) -> u64;
}

/// Paths of a [`Driven`] method.
struct DrivenPaths<'s, const D: usize> {
    paths: TailPaths<'s, D>,
    how: Driven,
    seed: u64,
}

impl<const D: usize> AtTime for DrivenPaths<'_, D> {
    fn exceedance(&self, t: f64, threshold: f64) -> Result<Observed, TailError> {
        let estimate = match self.how {
            Driven::Subset { config } => self.paths.subset(threshold, &config, self.seed),
            Driven::Importance { samples } => {
                self.paths.importance(threshold, Tails::Both, samples, self.seed)
            }
        };
        Ok(Observed::of_estimate(t, &estimate?))
    }

    fn n_followed(&self) -> u64 {
        self.paths.n_followed()
    }
}

/// Guided paths.
struct Guided<'s> {
    paths: GuidedPaths<'s>,
    config: GuidedConfig,
    n_followed: Cell<u64>,
}

impl AtTime for Guided<'_> {
    fn exceedance(&self, t: f64, threshold: f64) -> Result<Observed, TailError> {
        let n_paths = self.config.n_paths.saturating_add(self.config.n_pilots);
        self.n_followed.set(self.n_followed.get().saturating_add(n_paths));
        let found = self.paths.exceedance(threshold, Tails::Both, &self.config)?;
        Ok(Observed::of_guided(t, &found))
    }

    fn n_followed(&self) -> u64 {
        self.n_followed.get()
    }
}

/// Creates the paths to a time in a number of steps; all other code is compiled once for each number of states.
type PathsTo<'s, const D: usize> = &'s dyn Fn(
    &GaussianMixture<D>,
    (f64, usize),
    [f64; D],
) -> Result<Box<dyn AtTime + 's>, PathsError>;

impl Visitor for TailsOf<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let Self { integrator, seed, how, .. } = self;
        let samples = match how {
            Estimator::Guided { samples } => samples,
            Estimator::Driven(how) => {
                return self.tails::<D>(&|law, span, weights| {
                    let paths = system.tails(integrator, law, span)?.with_demand(weights);
                    Ok(Box::new(DrivenPaths { paths, how, seed }))
                });
            }
        };
        let order = order(self.system.kinks());
        let rule = Linearisation { order, step: self.system.reference_period() / STEPS_OF_GUIDE };
        let (n_pilots, unguided) = ((samples / 4).max(200), UNGUIDED);
        let config = GuidedConfig { n_paths: samples, n_pilots, unguided, seed };
        self.tails::<D>(&|law, span, weights| {
            let paths = system.guided(integrator, law, span, &rule)?;
            let paths = paths.with_demand(&weights).map_err(PathsError::from)?;
            Ok(Box::new(Guided { paths, config, n_followed: Cell::new(0) }))
        })
    }
}

impl TailsOf<'_> {
    fn tails<const D: usize>(self, paths_to: PathsTo<'_, D>) -> Result<Outcome, RunError> {
        let Self { scene, system: named, run, step, seed, how, .. } = self;
        let (law, asked) = (law::<D>(scene, named)?, asked::<D>(scene, named, false)?);
        let weights = std::array::from_fn(|k| asked.demand.weights[k]);
        let (mut values, mut unknown) = (vec![Vec::new(); asked.thresholds.len()], Vec::new());
        if !scene.moments.is_empty() {
            let reason =
                format!("the method ({}) estimates exceedance probabilities alone", how.name());
            unknown.push(Unknown { what: "all moments".to_owned(), reason });
        }
        run.progress.stage(how.name());
        let (clock, mut path_steps) = (CpuClock::start(), 0);
        for (row, &t) in asked.times.iter().enumerate() {
            let n_steps = steps(t, step);
            let paths = paths_to(&law, (t, n_steps), weights)?;
            for (values, &threshold) in values.iter_mut().zip(&asked.thresholds) {
                match paths.exceedance(t, threshold) {
                    Ok(observed) => values.push(observed),
                    Err(
                        error @ (TailError::Untrusted { .. }
                        | TailError::Sampling(
                            Error::NoDesignPoint { .. } | Error::TooManyLevels { .. },
                        )),
                    ) => unknown.push(Unknown {
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
        let exceedance = |k: usize| values[k].clone();
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
