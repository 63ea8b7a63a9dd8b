//! What half the step changes: the bias of the steps of an ensemble, from pairs of paths.

use crate::ensembles::ensemble::Study;
use crate::ensembles::schedule::Leg;
use crate::ensembles::tally::{Observable, Observed};
use crate::error::Error;
use crate::estimate::{Accumulator, Estimate};
use crate::integrator::Integrator;
use crate::law::InitialDistribution;
use crate::noise::streams::{Increment, Noise, PathNoise};

/// What half the step changes of an observable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepDifference {
    /// Mean of the value with half the step less that with the whole one.
    pub difference: Estimate,
    /// Mean of the value with half the step.
    pub value: Estimate,
}

impl<S, I, L, const D: usize> Study<'_, S, I, L, D>
where
    S: Sync + ?Sized,
    L: InitialDistribution<D> + ?Sized,
{
    /// Means of `f(X_{h/2}) - f(X_h)` and of `f(X_{h/2})` at each output time for each observable `f`, over pairs of paths that share
    /// initial state and Brownian motion, of `amplitude` times the noise of the system: a larger one leads paths to places that few
    /// reach. An event counts as 1 where it happens.
    ///
    /// With a method of weak order `p` the bias of the ensemble is `-2^p / (2^p - 1)` times the mean, to leading order. The pairs are
    /// the realisations after those of the ensemble.
    ///
    /// # Errors
    /// Those of [`Study::run`]; [`Error::TooFew`] below two pairs; [`Error::Step`], [`Error::NonFiniteState`] and
    /// [`Error::NonFiniteObservable`] of a path of a pair.
    ///
    /// Source: Giles 2008, Multilevel Monte Carlo path simulation, section 4.
    pub fn step_differences<const M: usize>(
        &self,
        n_pairs: u64,
        amplitude: f64,
    ) -> Result<Vec<Vec<StepDifference>>, Error>
    where
        I: Integrator<S, D, M>,
    {
        let legs = self.check()?;
        let mut sums = vec![[Accumulator::default(); 2]; legs.len() * self.observables.len()];
        let noise = Noise::new(self.config.seed);
        for realisation in self.config.n_paths..self.config.n_paths.saturating_add(n_pairs) {
            let x = self.law.sample(&noise, realisation);
            let walk = || Walk { x, memory: I::Memory::default(), n_steps: 0 };
            let mut pair = PairOfPaths { realisation, amplitude, whole: walk(), half: walk() };
            let mut motion = noise.path::<M>(realisation);
            for (leg, sums) in legs.iter().zip(sums.chunks_exact_mut(self.observables.len())) {
                self.pair_leg(leg, &mut motion, &mut pair)?;
                for (k, (observable, [difference, value])) in
                    self.observables.iter().zip(sums).enumerate()
                {
                    let of = |walk: &Walk<I::Memory, D>| {
                        observed(observable, leg.end, &walk.x).map_err(|value| {
                            let (observable, t) = (k, leg.end);
                            Error::NonFiniteObservable { observable, realisation, t, value }
                        })
                    };
                    let half = of(&pair.half)?;
                    value.push(half);
                    difference.push(half - of(&pair.whole)?);
                }
            }
        }
        let estimates = |[difference, value]: &[Accumulator; 2]| {
            Ok(StepDifference { difference: difference.estimate()?, value: value.estimate()? })
        };
        sums.chunks_exact(self.observables.len())
            .map(|row| row.iter().map(estimates).collect())
            .collect()
    }

    /// Both paths over a leg, each step of the one beside two of the other.
    fn pair_leg<const M: usize>(
        &self,
        leg: &Leg,
        motion: &mut PathNoise<M>,
        pair: &mut PairOfPaths<I::Memory, D>,
    ) -> Result<(), Error>
    where
        I: Integrator<S, D, M>,
    {
        let PairOfPaths { realisation, amplitude, whole, half } = pair;
        let (dt, short) = (leg.dt, 0.5 * leg.dt);
        for step in 0..leg.n_steps {
            let t = leg.start + step as f64 * dt;
            let [first, second] =
                [0, 1].map(|_| motion.next_increment(short).amplified(*amplitude));
            self.walk(*realisation, (t, short), &first, half)?;
            self.walk(*realisation, (t + short, short), &second, half)?;
            self.walk(*realisation, (t, dt), &Increment::from_halves(&first, &second), whole)?;
        }
        Ok(())
    }

    fn walk<const M: usize>(
        &self,
        realisation: u64,
        (t, dt): (f64, f64),
        dw: &Increment<M>,
        path: &mut Walk<I::Memory, D>,
    ) -> Result<(), Error>
    where
        I: Integrator<S, D, M>,
    {
        let Walk { x, memory, n_steps } = path;
        let step = *n_steps;
        self.integrator.step(self.system, t, dt, dw, x, memory).map_err(|source| Error::Step {
            realisation,
            step,
            t,
            source,
        })?;
        *n_steps += 1;
        match x.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(component) => {
                let (steps, t, value) = (*n_steps, t + dt, x[component]);
                Err(Error::NonFiniteState { realisation, steps, t, component, value })
            }
        }
    }
}

/// Two paths of one realisation.
struct PairOfPaths<Y, const D: usize> {
    realisation: u64,
    amplitude: f64,
    whole: Walk<Y, D>,
    half: Walk<Y, D>,
}

/// State and memory of a path.
struct Walk<Y, const D: usize> {
    x: [f64; D],
    memory: Y,
    n_steps: u64,
}

fn observed<const D: usize>(
    observable: &Observable<'_, D>,
    t: f64,
    x: &[f64; D],
) -> Result<f64, f64> {
    Ok(match Observed::of(observable, t, x)? {
        Observed::Value(value) => value,
        Observed::Event(happened) => f64::from(u8::from(happened)),
    })
}
