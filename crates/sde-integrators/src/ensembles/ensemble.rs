//! Ensembles: many paths of one system, and estimates of observables.

use std::ops::Range;

use simd_lanes::SimdLevel;

use crate::blocks::reduce_blocks;
use crate::ensembles::follow::{Follow, Lives, Watch};
use crate::ensembles::schedule::{EnsembleConfig, Leg, schedule};
use crate::ensembles::tally::{Observable, Observed, Tally};
use crate::error::Error;
use crate::estimate::Estimate;
use crate::integrator::Integrator;
use crate::law::InitialDistribution;
use crate::noise::lane_increments::LANES;

/// Results of an ensemble.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Ensemble {
    /// The requested output times.
    pub times: Vec<f64>,
    /// Per output time, per observable.
    pub estimates: Vec<Vec<Estimate>>,
    /// Number of paths.
    pub n_paths: u64,
    /// Number of steps over all paths.
    pub path_steps: u128,
}

/// An ensemble with all its options; [`simulate`] uses the default options.
///
/// [`run`](Self::run) computes all paths, [`shard`](Self::shard) a part of them.
#[derive(Debug)]
pub struct Study<'a, S: ?Sized, I, L: ?Sized, const D: usize> {
    /// Name of the study: shards of studies with different names are not merged.
    pub name: &'a str,
    /// The system.
    pub system: &'a S,
    /// The method.
    pub integrator: &'a I,
    /// Distribution of the initial state.
    pub law: &'a L,
    /// Number of paths, step and output times.
    pub config: &'a EnsembleConfig,
    /// Observables.
    pub observables: &'a [Observable<'a, D>],
    /// SIMD level; results are bitwise identical at every level.
    pub level: SimdLevel,
}

/// Simulates `n_paths` paths of a system and estimates the observables at the output times.
///
/// The result is a function of the arguments alone: bitwise identical for any number of threads, at every SIMD level,
/// and with or without the feature `rayon`. Each path is realisation `0, 1, ..` of
/// [`Noise::new`](crate::Noise::new)`(config.seed)`. Paths advance in groups of [`LANES`]; a step allocates nothing.
///
/// # Errors
/// Invalid configuration: [`Error::NotPositive`] (`dt`), [`Error::OutputTime`], [`Error::TooFew`] (paths, times,
/// observables), [`Error::TooMany`] (steps). Failed path: [`Error::Step`], [`Error::NonFiniteState`],
/// [`Error::NonFiniteObservable`], always that of the lowest path that fails. No path is ever dropped; [`Study::run`]
/// counts failed paths.
pub fn simulate<S, I, L, const D: usize, const M: usize>(
    system: &S,
    integrator: &I,
    law: &L,
    config: &EnsembleConfig,
    observables: &[Observable<'_, D>],
) -> Result<Ensemble, Error>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
    L: InitialDistribution<D> + ?Sized,
{
    let level = SimdLevel::best();
    let study = Study { name: "", system, integrator, law, config, observables, level };
    let legs = study.check()?;
    let tallies = reduce_blocks(
        config.n_paths,
        |ids| {
            let block = study.block::<M>(&legs, ids, Failing::Stops);
            block.first_failure.map_or(Ok(block.tallies), |(_, error)| Err(error))
        },
        merge_tallies,
    )?;
    study.ensemble(&tallies.unwrap_or_default())
}

/// Results of the paths of one block.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub(crate) tallies: Vec<Tally>,
    pub(crate) n_failed: u64,
    pub(crate) first_failure: Option<(u64, Error)>,
}

/// Handling of a failed path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Failing {
    /// It stops the ensemble: paths of higher numbers need not run.
    Stops,
    /// It is counted.
    Counts,
}

impl<S, I, L, const D: usize> Study<'_, S, I, L, D>
where
    S: Sync + ?Sized,
    L: InitialDistribution<D> + ?Sized,
{
    pub(crate) fn check(&self) -> Result<Vec<Leg>, Error> {
        if self.observables.is_empty() {
            schedule(self.config)?;
            return Err(Error::TooFew { quantity: "observables", value: 0, limit: 1 });
        }
        schedule(self.config)
    }

    /// Tallies of a block of paths, observable by observable for each output time.
    pub(crate) fn block<const M: usize>(
        &self,
        legs: &[Leg],
        ids: Range<u64>,
        failing: Failing,
    ) -> Block
    where
        I: Integrator<S, D, M>,
    {
        let Self { system, integrator, law, level, .. } = *self;
        let seed = self.config.seed;
        let follow = Follow { system, integrator, law, seed, legs, level };
        let mut tallies = Vec::with_capacity(legs.len() * self.observables.len());
        for _ in legs {
            tallies.extend(self.observables.iter().map(Tally::new));
        }
        let mut observer = Observer { observables: self.observables, tallies };
        let (mut n_failed, mut first_failure) = (0, None);
        let mut start = ids.start;
        while start < ids.end && !(n_failed > 0 && failing == Failing::Stops) {
            let end = ids.end.min(start + LANES as u64);
            let lives = follow.group::<D, M, _>(&(start..end), &mut observer);
            for failure in lives.into_failures() {
                n_failed += 1;
                first_failure.get_or_insert(failure);
            }
            start = end;
        }
        Block { tallies: observer.tallies, n_failed, first_failure }
    }

    pub(crate) fn ensemble(&self, tallies: &[Tally]) -> Result<Ensemble, Error> {
        let legs = schedule(self.config)?;
        let steps: u64 = legs.iter().map(|leg| leg.n_steps).sum();
        let EnsembleConfig { n_paths, ref times, .. } = *self.config;
        Ok(Ensemble {
            times: times.clone(),
            estimates: estimates(tallies, self.observables.len())?,
            n_paths,
            path_steps: u128::from(steps) * u128::from(n_paths),
        })
    }
}

pub(crate) fn estimates(
    tallies: &[Tally],
    n_observables: usize,
) -> Result<Vec<Vec<Estimate>>, Error> {
    tallies
        .chunks_exact(n_observables)
        .map(|row| row.iter().map(Tally::estimate).collect())
        .collect()
}

pub(crate) fn merge_tallies(mut earlier: Vec<Tally>, later: Vec<Tally>) -> Vec<Tally> {
    for (a, b) in earlier.iter_mut().zip(later) {
        a.merge(&b);
    }
    earlier
}

/// Observes the output times.
struct Observer<'a, const D: usize> {
    observables: &'a [Observable<'a, D>],
    tallies: Vec<Tally>,
}

impl<const D: usize> Observer<'_, D> {
    /// What an observable is on a path, unless the path has failed.
    fn observe(
        &self,
        observable: usize,
        t: f64,
        x: &[[f64; LANES]],
        lane: usize,
        lives: &mut Lives,
    ) -> Option<Observed> {
        if !lives.is_alive(lane) {
            return None;
        }
        let state = std::array::from_fn(|i| x[i][lane]);
        Observed::of(&self.observables[observable], t, &state)
            .map_err(|value| {
                lives.fail(lane, |realisation| Error::NonFiniteObservable {
                    observable,
                    realisation,
                    t,
                    value,
                });
            })
            .ok()
    }
}

impl<const D: usize> Watch for Observer<'_, D> {
    const EVERY_STEP: bool = false;

    fn start(&mut self, _: u64, _: &[[f64; LANES]]) {}

    fn step(&mut self, _: (f64, f64), _: &[[f64; LANES]], _: &[[f64; LANES]]) {}

    fn output(&mut self, leg: usize, t: f64, x: &[[f64; LANES]], lives: &mut Lives) {
        let n = self.observables.len();
        for observable in 0..n {
            for lane in 0..lives.n_active {
                if let Some(observed) = self.observe(observable, t, x, lane, lives) {
                    self.tallies[leg * n + observable].push(observed);
                }
            }
        }
    }
}
