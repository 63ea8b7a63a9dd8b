//! Ensembles: many paths of one system, and what is observed of them.

use std::ops::Range;

use lanes::SimdLevel;

use crate::blocks::reduce_blocks;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::follow::{Follow, LaneStates, Lives, Watch};
use crate::integrator::Integrator;
use crate::lane_increments::LANES;
use crate::law::InitialLaw;
use crate::schedule::{EnsembleConfig, Leg, schedule};
use crate::tally::{Observable, Sampling, Seen, Tally};

/// What an ensemble came to.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Ensemble {
    /// The output times, as asked for.
    pub times: Vec<f64>,
    /// Per output time, per observable.
    pub estimates: Vec<Vec<Estimate>>,
    /// How many paths were followed.
    pub n_paths: u64,
    /// The work: steps taken, over all paths.
    pub path_steps: u128,
}

/// An ensemble with all its choices: what [`simulate`] does with the usual ones.
///
/// [`run`](Self::run) follows all paths, [`shard`](Self::shard) a part of them.
#[derive(Debug)]
pub struct Study<'a, S: ?Sized, I, L: ?Sized, const D: usize> {
    /// Its name: shards of studies of different names are not merged.
    pub name: &'a str,
    /// The system.
    pub system: &'a S,
    /// The method.
    pub integrator: &'a I,
    /// The law of the initial state.
    pub law: &'a L,
    /// How many paths, how finely, until when.
    pub config: &'a EnsembleConfig,
    /// What is observed.
    pub observables: &'a [Observable<'a, D>],
    /// How the paths belong together.
    pub sampling: Sampling,
    /// The instructions used; the bits are the same at every level.
    pub level: SimdLevel,
}

/// Follow `n_paths` paths of a system and estimate the observables at the output times.
///
/// The result is a function of its arguments alone: the same bits for any number of threads, at every level of vector
/// instructions, and with or without the feature `rayon`. Each path is realisation number `0, 1, ..` of
/// [`Noise::new`](crate::Noise::new)`(config.seed)`. Paths move in groups of [`LANES`]; nothing is allocated per step.
///
/// # Errors
/// A bad configuration: [`Error::NotPositive`] (`dt`), [`Error::OutputTime`], [`Error::TooFew`] (paths, times,
/// observables), [`Error::TooMany`] (steps). A failed path: [`Error::Step`], [`Error::NonFiniteState`],
/// [`Error::NonFiniteObservable`], always that of the lowest path that fails. No path is ever dropped; to count those
/// that fail use [`Study::run`].
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
    L: InitialLaw<D> + ?Sized,
{
    let (sampling, level) = (Sampling::Independent, SimdLevel::best());
    let study = Study { name: "", system, integrator, law, config, observables, sampling, level };
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

/// What the paths of one block came to.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub(crate) tallies: Vec<Tally>,
    pub(crate) n_failed: u64,
    pub(crate) first_failure: Option<(u64, Error)>,
}

/// What happens when a path fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Failing {
    /// Paths of higher numbers need not be followed.
    Stops,
    /// It is counted.
    Counts,
}

impl<S, I, L, const D: usize> Study<'_, S, I, L, D>
where
    S: Sync + ?Sized,
    L: InitialLaw<D> + ?Sized,
{
    pub(crate) fn check(&self) -> Result<Vec<Leg>, Error> {
        if self.observables.is_empty() {
            schedule(self.config)?;
            return Err(Error::TooFew { quantity: "observables", value: 0, limit: 1 });
        }
        let n_paths = self.config.n_paths;
        if self.sampling == Sampling::Antithetic && n_paths % 2 == 1 {
            return Err(Error::NotEven { quantity: "antithetic paths", value: n_paths });
        }
        schedule(self.config)
    }

    /// The tallies of a block of paths, observable by observable for each output time.
    pub(crate) fn block<const M: usize>(
        &self,
        legs: &[Leg],
        ids: Range<u64>,
        failing: Failing,
    ) -> Block
    where
        I: Integrator<S, D, M>,
    {
        let Self { system, integrator, law, sampling, level, .. } = *self;
        let seed = self.config.seed;
        let follow = Follow { system, integrator, law, seed, legs, sampling, level };
        let mut tallies = Vec::with_capacity(legs.len() * self.observables.len());
        for leg in legs {
            tallies.extend(self.observables.iter().map(|o| Tally::new(o, leg.end, sampling)));
        }
        let mut observer = Observer { observables: self.observables, sampling, tallies };
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

/// Looks at the output times.
struct Observer<'a, const D: usize> {
    observables: &'a [Observable<'a, D>],
    sampling: Sampling,
    tallies: Vec<Tally>,
}

impl<const D: usize> Observer<'_, D> {
    fn see(
        &self,
        observable: usize,
        t: f64,
        x: &LaneStates<D>,
        lane: usize,
        lives: &mut Lives,
    ) -> Option<Seen> {
        if !lives.is_alive(lane) {
            return None;
        }
        let state = std::array::from_fn(|i| x[i][lane]);
        Seen::of(&self.observables[observable], t, &state)
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

impl<const D: usize> Watch<D> for Observer<'_, D> {
    const EVERY_STEP: bool = false;

    fn start(&mut self, _: u64, _: &LaneStates<D>) {}

    fn step(&mut self, _: (f64, f64), _: &LaneStates<D>, _: &LaneStates<D>) {}

    fn output(&mut self, leg: usize, t: f64, x: &LaneStates<D>, lives: &mut Lives) {
        let n = self.observables.len();
        let stride = if self.sampling == Sampling::Antithetic { 2 } else { 1 };
        for observable in 0..n {
            for lane in (0..lives.n_active).step_by(stride) {
                let mut seen = self.see(observable, t, x, lane, lives);
                if stride == 2 {
                    let other = self.see(observable, t, x, lane + 1, lives);
                    seen = seen.zip(other).map(|(a, b)| a.pair(b));
                }
                if let Some(seen) = seen {
                    self.tallies[leg * n + observable].push(seen);
                }
            }
        }
    }
}
