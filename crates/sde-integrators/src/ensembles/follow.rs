//! Simulation of paths in SIMD lanes, one path per lane.

use std::ops::Range;

use simd_lanes::{Registers, SimdLevel, Work};

use crate::ensembles::schedule::Leg;
use crate::error::Error;
use crate::integrator::{Integrator, Joints};
use crate::law::InitialDistribution;
use crate::noise::lane_increments::{LANES, LaneIncrements, LaneNoise};
use crate::noise::streams::Noise;

/// The states of [`LANES`] paths, component by component.
pub(crate) type LaneStates<const D: usize> = [[f64; LANES]; D];

/// Data common to all paths.
pub(crate) struct Follow<'a, S: ?Sized, I, L: ?Sized> {
    pub(crate) system: &'a S,
    pub(crate) integrator: &'a I,
    pub(crate) law: &'a L,
    pub(crate) seed: u64,
    pub(crate) legs: &'a [Leg],
    pub(crate) level: SimdLevel,
}

/// Observer of the paths during a simulation.
pub(crate) trait Watch {
    /// Whether [`step`](Self::step) is called.
    const EVERY_STEP: bool;

    /// Called at the start of a group, with its first realisation and its states.
    fn start(&mut self, first: u64, x: &[[f64; LANES]]);

    /// Called after a step from `before` at `t` to `after` at `t + dt`; `time` contains both times.
    fn step(&mut self, time: (f64, f64), before: &[[f64; LANES]], after: &[[f64; LANES]]);

    /// Called at an output time.
    fn output(&mut self, leg: usize, t: f64, x: &[[f64; LANES]], lives: &mut Lives);
}

/// Lanes in use, and failed paths with their first errors.
pub(crate) struct Lives {
    pub(crate) first: u64,
    pub(crate) n_active: usize,
    failures: [Option<Box<Error>>; LANES],
}

impl Lives {
    pub(crate) fn new(ids: &Range<u64>) -> Self {
        let n_active = usize::try_from(ids.end - ids.start).unwrap_or(LANES).min(LANES);
        Self { first: ids.start, n_active, failures: [const { None }; LANES] }
    }

    pub(crate) fn realisation(&self, lane: usize) -> u64 {
        self.first + lane as u64
    }

    pub(crate) fn is_alive(&self, lane: usize) -> bool {
        self.failures[lane].is_none()
    }

    #[cold]
    pub(crate) fn fail(&mut self, lane: usize, error: impl FnOnce(u64) -> Error) {
        if lane < self.n_active && self.is_alive(lane) {
            self.failures[lane] = Some(Box::new(error(self.realisation(lane))));
        }
    }

    /// Marks paths with a non-finite state as failed, and sets them to zero so that each is found once.
    #[cold]
    #[inline(never)]
    pub(crate) fn bury(&mut self, x: &mut [[f64; LANES]], steps: u64, t: f64) {
        for lane in 0..LANES {
            let Some(component) = x.iter().position(|row| !row[lane].is_finite()) else { continue };
            let value = x[component][lane];
            self.fail(lane, |realisation| Error::NonFiniteState {
                realisation,
                steps,
                t,
                component,
                value,
            });
            for row in x.iter_mut() {
                row[lane] = 0.0;
            }
        }
    }

    /// The failures, by realisation.
    pub(crate) fn into_failures(self) -> impl Iterator<Item = (u64, Error)> {
        let first = self.first;
        self.failures
            .into_iter()
            .enumerate()
            .filter_map(move |(lane, error)| Some((first + lane as u64, *error?)))
    }
}

#[allow(clippy::inline_always, reason = "used in a dispatched function")]
#[allow(clippy::eq_op, reason = "what is not finite less itself is not zero")]
#[inline(always)]
pub(crate) fn all_finite(x: &[[f64; LANES]]) -> bool {
    let mut bits = 0_u64;
    for row in x {
        for lane in 0..LANES {
            // Zero for finite values, NaN otherwise; cheaper than a comparison of each.
            bits |= (row[lane] - row[lane]).to_bits();
        }
    }
    bits == 0
}

impl<S, I, L> Follow<'_, S, I, L>
where
    S: Sync + ?Sized,
    L: ?Sized,
{
    /// Simulates at most [`LANES`] paths over the whole time.
    pub(crate) fn group<const D: usize, const M: usize, W>(
        &self,
        ids: &Range<u64>,
        watch: &mut W,
    ) -> Lives
    where
        I: Integrator<S, D, M>,
        L: InitialDistribution<D>,
        W: Watch,
    {
        let mut lives = Lives::new(ids);
        let streams: [u64; LANES] = std::array::from_fn(|lane| ids.start.wrapping_add(lane as u64));
        let mut x = [[0.0; LANES]; D];
        let noise = Noise::new(self.seed);
        for lane in 0..lives.n_active {
            let state = self.law.sample(&noise, streams[lane]);
            for i in 0..D {
                x[i][lane] = state[i];
            }
        }
        if !all_finite(&x) {
            lives.bury(&mut x, 0, 0.0);
        }
        watch.start(ids.start, &x);
        let mut noise = LaneNoise::<M>::new(self.level, self.seed, streams);
        let mut memory: [I::Memory; LANES] = std::array::from_fn(|_| I::Memory::default());
        let mut steps_before = 0;
        for (index, leg) in self.legs.iter().enumerate() {
            self.level.run(Advance {
                follow: self,
                leg,
                steps_before,
                noise: &mut noise,
                x: &mut x,
                memory: &mut memory,
                lives: &mut lives,
                watch,
            });
            steps_before += leg.n_steps;
            watch.output(index, leg.end, &x, &mut lives);
        }
        lives
    }
}

/// The steps between two output times.
struct Advance<'a, 'b, S: ?Sized, I, L: ?Sized, W, Memory, const D: usize, const M: usize> {
    follow: &'a Follow<'b, S, I, L>,
    leg: &'a Leg,
    steps_before: u64,
    noise: &'a mut LaneNoise<M>,
    x: &'a mut LaneStates<D>,
    memory: &'a mut [Memory; LANES],
    lives: &'a mut Lives,
    watch: &'a mut W,
}

impl<S, I, L, W, const D: usize, const M: usize> Work<f64>
    for Advance<'_, '_, S, I, L, W, I::Memory, D, M>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
    L: ?Sized,
    W: Watch,
{
    type Output = ();

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        let Self { follow, leg, steps_before, noise, x, memory, lives, watch } = self;
        let (integrator, system) = (follow.integrator, follow.system);
        let (deviation, area_deviation) = (leg.dt.sqrt(), (leg.dt / 12.0).sqrt());
        let mut dw = LaneIncrements::ZERO;
        let mut before = *x;
        for k in 0..leg.n_steps {
            let t = leg.start + k as f64 * leg.dt;
            if I::USES_AREA {
                noise.next::<true>(deviation, area_deviation, &mut dw);
            } else {
                noise.next::<false>(deviation, area_deviation, &mut dw);
            }
            if W::EVERY_STEP {
                before = *x;
            }
            let step = steps_before + k;
            let mut failed = |lane, source| {
                lives.fail(lane, |realisation| Error::Step { realisation, step, t, source });
            };
            let joints = Joints {
                before: !W::EVERY_STEP && k > 0,
                after: !W::EVERY_STEP && k + 1 < leg.n_steps,
            };
            integrator.step_lanes_joined(joints, system, t, leg.dt, &dw, x, memory, &mut failed);
            if !all_finite(x) {
                lives.bury(x, step + 1, t + leg.dt);
            }
            if W::EVERY_STEP {
                watch.step((t, leg.dt), &before, x);
            }
        }
    }
}
