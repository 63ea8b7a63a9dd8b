//! Ensembles: many paths of one system, and what is observed of them.

use std::fmt;
use std::ops::Range;

use crate::blocks::reduce_blocks;
use crate::error::Error;
use crate::estimate::{Accumulator, Estimate};
use crate::integrator::Integrator;
use crate::law::InitialLaw;
use crate::noise::Noise;

/// What is simulated: how many paths, how finely, until when. Paths start at `t = 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct EnsembleConfig {
    /// All randomness follows from it.
    pub seed: u64,
    /// How many paths, at least 2; they are the realisations from 0 on.
    pub n_paths: u64,
    /// The largest step length (time). Between two output times the steps are equal, as few as that allows, and the
    /// last ends exactly on the output time: `ceil(interval/dt)` steps, where a quotient within a relative 1e-9 above
    /// a whole number counts as that number.
    pub dt: f64,
    /// When to observe (time): ascending, none negative. Zero observes the initial law.
    pub times: Vec<f64>,
}

impl EnsembleConfig {
    /// The largest number of steps per path: beyond it step numbers are no longer exact in `f64`.
    pub const MAX_STEPS: u64 = 1 << 53;
}

/// What is observed of every path at every output time.
///
/// ```
/// use sde_integrators::Observable;
///
/// let threshold = 0.5;
/// let exceeds = |_t: f64, x: &[f64; 2]| x[0].abs() > threshold;
/// let observables =
///     [Observable::Mean(&|_t, x| x[0] * x[0]), Observable::Probability(&exceeds)];
/// assert_eq!(observables.len(), 2);
/// ```
#[derive(Clone, Copy)]
pub enum Observable<'a, const D: usize> {
    /// The mean of a function of time and state, with the standard error of the sample mean.
    Mean(&'a (dyn Fn(f64, &[f64; D]) -> f64 + Sync)),
    /// The probability of an event, with the error of [`Estimate::probability`].
    Probability(&'a (dyn Fn(f64, &[f64; D]) -> bool + Sync)),
}

impl<const D: usize> fmt::Debug for Observable<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean(_) => "Mean(..)",
            Self::Probability(_) => "Probability(..)",
        })
    }
}

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

/// Follow `n_paths` paths of a system and estimate the observables at the output times.
///
/// The result is a function of its arguments alone: the same bits for any number of threads, and with or without the
/// feature `rayon`. Each path is realisation number `0, 1, ..` of [`Noise::new`]`(config.seed)`.
/// After the first step nothing is allocated per path or step.
///
/// # Errors
/// A bad configuration: [`Error::NotPositive`] (`dt`), [`Error::OutputTime`], [`Error::TooFew`] (paths, times,
/// observables), [`Error::TooMany`] (steps). A failed path: [`Error::Step`], [`Error::NonFiniteState`],
/// [`Error::NonFiniteObservable`], always that of the lowest path that fails. No path is ever dropped.
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
    let legs = schedule(config)?;
    if observables.is_empty() {
        return Err(Error::TooFew { quantity: "observables", value: 0, limit: 1 });
    }
    let noise = Noise::new(config.seed);
    let run = Run { system, integrator, law, noise, legs: &legs, observables };
    let tallies = reduce_blocks(config.n_paths, |ids| run.block::<M>(ids), merge)?;
    let tallies = tallies.unwrap_or_default();
    let estimates = tallies
        .chunks_exact(observables.len())
        .map(|row| row.iter().map(Tally::estimate).collect())
        .collect::<Result<_, _>>()?;
    let steps: u64 = legs.iter().map(|leg| leg.n_steps).sum();
    Ok(Ensemble {
        times: config.times.clone(),
        estimates,
        n_paths: config.n_paths,
        path_steps: u128::from(steps) * u128::from(config.n_paths),
    })
}

/// The steps between two output times.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Leg {
    start: f64,
    end: f64,
    n_steps: u64,
    dt: f64,
}

/// Check the configuration and divide the time.
fn schedule(config: &EnsembleConfig) -> Result<Vec<Leg>, Error> {
    let EnsembleConfig { n_paths, dt, ref times, .. } = *config;
    if n_paths < 2 {
        return Err(Error::TooFew { quantity: "paths", value: n_paths, limit: 2 });
    }
    if !(dt.is_finite() && dt > 0.0) {
        return Err(Error::NotPositive { quantity: "dt", value: dt });
    }
    if times.is_empty() {
        return Err(Error::TooFew { quantity: "output times", value: 0, limit: 1 });
    }
    let mut legs = Vec::with_capacity(times.len());
    let (mut start, mut relation, mut total) = (0.0, "at least", 0.0);
    for (index, &end) in times.iter().enumerate() {
        if !end.is_finite() || end < start || (index > 0 && end <= start) {
            return Err(Error::OutputTime { index, value: end, relation, limit: start });
        }
        let steps = ((end - start) / dt * (1.0 - 1e-9)).ceil();
        total += steps;
        let limit = EnsembleConfig::MAX_STEPS as f64;
        if total > limit {
            return Err(Error::TooMany { quantity: "steps per path", value: total, limit });
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to 2^53"
        )]
        let n_steps = steps as u64;
        let dt = if n_steps > 0 { (end - start) / steps } else { 0.0 };
        legs.push(Leg { start, end, n_steps, dt });
        (start, relation) = (end, "above");
    }
    Ok(legs)
}

/// What has been seen of one observable at one output time.
#[derive(Debug, Clone, Copy)]
enum Tally {
    Values(Accumulator),
    Events { hits: u64, trials: u64 },
}

impl Tally {
    fn new<const D: usize>(observable: &Observable<'_, D>) -> Self {
        match observable {
            Observable::Mean(_) => Self::Values(Accumulator::default()),
            Observable::Probability(_) => Self::Events { hits: 0, trials: 0 },
        }
    }

    fn estimate(&self) -> Result<Estimate, Error> {
        match *self {
            Self::Values(values) => values.estimate(),
            Self::Events { hits, trials } => Estimate::probability(hits, trials),
        }
    }

    fn merge(&mut self, later: &Self) {
        match (self, later) {
            (Self::Values(a), Self::Values(b)) => a.merge(b),
            (Self::Events { hits, trials }, Self::Events { hits: h, trials: n }) => {
                *hits += h;
                *trials += n;
            }
            _ => unreachable!("tallies of one observable are of one kind"),
        }
    }
}

fn merge(mut earlier: Vec<Tally>, later: Vec<Tally>) -> Vec<Tally> {
    for (a, b) in earlier.iter_mut().zip(later) {
        a.merge(&b);
    }
    earlier
}

/// Everything the paths share.
struct Run<'a, S: ?Sized, I, L: ?Sized, const D: usize> {
    system: &'a S,
    integrator: &'a I,
    law: &'a L,
    noise: Noise,
    legs: &'a [Leg],
    observables: &'a [Observable<'a, D>],
}

impl<S, I, L, const D: usize> Run<'_, S, I, L, D>
where
    S: Sync + ?Sized,
    L: InitialLaw<D> + ?Sized,
{
    /// The tallies of a block of paths, observable by observable for each output time.
    fn block<const M: usize>(&self, ids: Range<u64>) -> Result<Vec<Tally>, Error>
    where
        I: Integrator<S, D, M>,
    {
        let per_time = || self.observables.iter().map(Tally::new);
        let mut tallies: Vec<_> = self.legs.iter().flat_map(|_| per_time()).collect();
        for realisation in ids {
            self.path::<M>(realisation, &mut tallies)?;
        }
        Ok(tallies)
    }

    fn path<const M: usize>(&self, realisation: u64, tallies: &mut [Tally]) -> Result<(), Error>
    where
        I: Integrator<S, D, M>,
    {
        let mut x = self.law.sample(&self.noise, realisation);
        require_finite(&x, realisation, 0, 0.0)?;
        let mut path = self.noise.path::<M>(realisation);
        let mut memory = I::Memory::default();
        let mut step = 0;
        for (leg, tallies) in self.legs.iter().zip(tallies.chunks_exact_mut(self.observables.len()))
        {
            for k in 0..leg.n_steps {
                let t = leg.start + k as f64 * leg.dt;
                let dw = path.next_increment(leg.dt);
                self.integrator
                    .step(self.system, t, leg.dt, &dw, &mut x, &mut memory)
                    .map_err(|source| Error::Step { realisation, step, t, source })?;
                step += 1;
                require_finite(&x, realisation, step, t + leg.dt)?;
            }
            self.observe(leg.end, &x, realisation, tallies)?;
        }
        Ok(())
    }

    fn observe(
        &self,
        t: f64,
        x: &[f64; D],
        realisation: u64,
        tallies: &mut [Tally],
    ) -> Result<(), Error> {
        for (observable, (seen, tally)) in self.observables.iter().zip(tallies).enumerate() {
            match (seen, tally) {
                (Observable::Mean(f), Tally::Values(values)) => {
                    let value = f(t, x);
                    if !value.is_finite() {
                        return Err(Error::NonFiniteObservable {
                            observable,
                            realisation,
                            t,
                            value,
                        });
                    }
                    values.push(value);
                }
                (Observable::Probability(event), Tally::Events { hits, trials }) => {
                    *hits += u64::from(event(t, x));
                    *trials += 1;
                }
                _ => unreachable!("a tally is of the kind of its observable"),
            }
        }
        Ok(())
    }
}

#[inline]
fn require_finite<const D: usize>(
    x: &[f64; D],
    realisation: u64,
    steps: u64,
    t: f64,
) -> Result<(), Error> {
    if x.iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(non_finite(*x, realisation, steps, t))
    }
}

/// By value: a search in place would keep the state of every path in memory instead of registers.
#[cold]
fn non_finite<const D: usize>(x: [f64; D], realisation: u64, steps: u64, t: f64) -> Error {
    let component = x.iter().position(|value| !value.is_finite()).unwrap_or(0);
    Error::NonFiniteState { realisation, steps, t, component, value: x[component] }
}
