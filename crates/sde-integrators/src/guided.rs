//! Guided paths: a feedback shifts the normals of a path towards an event, and likelihood ratios undo its effect.

use std::ops::Range;

use lanes::{Registers, SimdLevel, Work};

use crate::blocks::reduce_blocks;
use crate::error::Error;
use crate::follow::{LaneStates, Lives, Watch, all_finite};
use crate::guide::{Guide, LARGEST_SHIFT, hazard};
use crate::integrator::{Integrator, Joints};
use crate::lane_increments::{Deviations, LANES, LaneIncrements, LaneNoise};
use crate::maximum::{Maximum, Response};
use crate::noise::{Noise, Purpose};

/// A path of a [`GuidedEnsemble`].
#[derive(Debug)]
pub struct GuidedPath<'a, const D: usize> {
    /// Its number.
    pub realisation: u64,
    /// The last state.
    pub end: [f64; D],
    /// Largest response, if one is asked for; otherwise `-inf`.
    pub largest: f64,
    /// Logarithm of the density of its normals under each guide over that without a guide.
    pub log_ratios: &'a [f64],
    /// Logarithm of the weight: the density without a guide over that of the mixture.
    pub log_weight: f64,
}

/// Paths from a normal initial distribution, each under one of several guides.
///
/// The guide of a path is drawn by its share; the rest, `1 - sum`, is without a guide. For a function `F` of the path
///
/// $$ E\[F\] = E_q\[F w\], \qquad w = \Big( c_0 + \sum_j c_j r_j \Big)^{-1}, \qquad
///    \ln r_j = \sum_k \Big( \theta_{jk} \cdot n_k - \tfrac12 |\theta_{jk}|^2 \Big), $$
///
/// with the shares `c`, the normals `n_k` of step `k` (and of the start), the shift `theta_jk` that guide `j` gives at
/// the state before the step, and `q` the mixture. A weight is at most `1/c_0`. The weights are exact for any guide and
/// any method, because they are those of the discrete normals; the guides determine the variance alone. Where a level is
/// given, the guides of a path end after the step in which it passes the level.
///
/// Choice of the guide and normals of the start are drawn from [`Purpose::InitialDistribution`], the others as in
/// [`simulate`](crate::simulate). Paths advance in groups of [`LANES`]; a step allocates nothing.
///
/// Sources: Girsanov 1960, On transforming a certain class of stochastic processes by absolutely continuous
/// substitution of measures; mixture weights (balance heuristic): Veach and Guibas 1995, Optimally combining sampling
/// techniques for Monte Carlo rendering; defensive share: Hesterberg 1995, Weighted average importance sampling and
/// defensive mixture distributions.
#[derive(Debug)]
pub struct GuidedEnsemble<'a, S: ?Sized, I, const D: usize, const M: usize> {
    /// The system.
    pub system: &'a S,
    /// The method.
    pub integrator: &'a I,
    /// Mean of the initial distribution (units of the states).
    pub mean: [f64; D],
    /// `L`, lower triangular, with the initial covariance `L L^T`.
    pub factor: [[f64; D]; D],
    /// Step length (time).
    pub dt: f64,
    /// Number of steps.
    pub n_steps: usize,
    /// The guides.
    pub guides: &'a [Guide<D, M>],
    /// Response whose maximum over the path is computed, if any, and the level at which the guides of a path end.
    pub passage: Option<(&'a Response<'a, D>, f64)>,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl<S, I, const D: usize, const M: usize> GuidedEnsemble<'_, S, I, D, M>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
{
    /// Simulates the paths of a range of realisations and collects them in blocks, by realisation in each.
    ///
    /// `new` makes an empty collection, `push` adds a path, `merge(earlier, later)` joins two, in the order of
    /// [`reduce_blocks`]: the result is bitwise identical for any number of threads.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the step length; [`Error::NotFinite`] for a number of a guide; [`Error::OutOfRange`] for
    /// shares that are not positive or exceed 1 together; those of [`maxima`](crate::maxima) for the response;
    /// [`Error::TooFew`] for no realisations; a failed path, [`Error::Step`] or [`Error::NonFiniteState`], always the lowest.
    pub fn run<A: Send>(
        &self,
        realisations: Range<u64>,
        new: impl Fn() -> A + Sync,
        push: impl Fn(&mut A, &GuidedPath<'_, D>) + Sync,
        merge: impl Fn(A, A) -> A + Sync,
    ) -> Result<A, Error> {
        let unguided = self.check()?;
        let n = realisations.end.saturating_sub(realisations.start);
        let block = |ids: Range<u64>| {
            let mut collected = new();
            let (from, to) = (realisations.start + ids.start, realisations.start + ids.end);
            let push = |path: &GuidedPath<'_, D>| push(&mut collected, path);
            match self.passage {
                Some((response, _)) => {
                    let watch = Maximum::new(response, self.seed, 1);
                    self.block(from..to, unguided, watch, push)?;
                }
                None => self.block(from..to, unguided, EndAlone, push)?,
            }
            Ok(collected)
        };
        let too_few = Error::TooFew { quantity: "paths", value: 0, limit: 1 };
        reduce_blocks(n, block, merge)?.ok_or(too_few)
    }

    /// Checks the input; returns the share of the paths without a guide.
    fn check(&self) -> Result<f64, Error> {
        if !(self.dt.is_finite() && self.dt > 0.0) {
            return Err(Error::NotPositive { quantity: "dt", value: self.dt });
        }
        if let Some((response, _)) = self.passage {
            response.check(self.dt)?;
        }
        let mut unguided = 1.0;
        for (index, guide) in self.guides.iter().enumerate() {
            if let Some(value) = guide.not_finite() {
                return Err(Error::NotFinite { quantity: "number of guide", index, value });
            }
            unguided -= guide.share;
            let value = guide.share;
            // Shares that add up to one within roundoff leave none.
            if !(value > 0.0 && unguided > -1e-12) {
                let (quantity, to) = ("share of a guide", (unguided + value).max(0.0));
                return Err(Error::OutOfRange { quantity, value, from: 0.0, to });
            }
        }
        Ok(if unguided < 1e-12 { 0.0 } else { unguided })
    }

    fn block<W: Largest<D>>(
        &self,
        ids: Range<u64>,
        unguided: f64,
        mut watch: W,
        mut push: impl FnMut(&GuidedPath<'_, D>),
    ) -> Result<(), Error> {
        let mut group = Group::new(self);
        let mut log_ratios = vec![0.0; self.guides.len()];
        let mut first = ids.start;
        while first < ids.end {
            let end = ids.end.min(first + LANES as u64);
            let mut lives = Lives::new(&(first..end));
            let (x, largest) = group.follow(&mut lives, &mut watch);
            let n_active = lives.n_active;
            if let Some((_, error)) = lives.into_failures().next() {
                return Err(error);
            }
            for lane in 0..n_active {
                for (value, ratios) in log_ratios.iter_mut().zip(&group.log_ratios) {
                    *value = ratios[lane];
                }
                push(&GuidedPath {
                    realisation: first + lane as u64,
                    end: std::array::from_fn(|i| x[i][lane]),
                    largest: largest[lane],
                    log_ratios: &log_ratios,
                    log_weight: -self.log_mixture(unguided, &log_ratios),
                });
            }
            first = end;
        }
        Ok(())
    }

    /// `ln(c_0 + sum_j c_j r_j)`.
    fn log_mixture(&self, unguided: f64, log_ratios: &[f64]) -> f64 {
        let none = if unguided > 0.0 { 0.0 } else { f64::NEG_INFINITY };
        let largest = log_ratios.iter().copied().fold(none, f64::max);
        let mut sum = unguided * (-largest).exp();
        for (guide, ratio) in self.guides.iter().zip(log_ratios) {
            sum += guide.share * (ratio - largest).exp();
        }
        largest + sum.ln()
    }
}

/// An observer that knows the largest response of each lane.
trait Largest<const D: usize>: Watch<D> {
    /// Largest responses since the start of the group.
    fn largest(&self) -> [f64; LANES];
}

impl<const D: usize> Largest<D> for Maximum<'_, D> {
    fn largest(&self) -> [f64; LANES] {
        self.running
    }
}

/// Observes nothing, so that steps may be joined.
struct EndAlone;

impl<const D: usize> Watch<D> for EndAlone {
    const EVERY_STEP: bool = false;
    fn start(&mut self, _: u64, _: &LaneStates<D>) {}
    fn step(&mut self, _: (f64, f64), _: &LaneStates<D>, _: &LaneStates<D>) {}
    fn output(&mut self, _: usize, _: f64, _: &LaneStates<D>, _: &mut Lives) {}
}

impl<const D: usize> Largest<D> for EndAlone {
    fn largest(&self) -> [f64; LANES] {
        [f64::NEG_INFINITY; LANES]
    }
}

/// [`LANES`] paths, with buffers that are reused.
struct Group<'a, 'b, S: ?Sized, I, const D: usize, const M: usize> {
    ensemble: &'a GuidedEnsemble<'b, S, I, D, M>,
    /// Per guide and lane: 1 if the path has the guide, otherwise 0.
    chosen: Vec<[f64; LANES]>,
    /// Per guide and lane: `lambda` of the current step.
    lambdas: Vec<[f64; LANES]>,
    /// Per guide and lane: `ln r`.
    log_ratios: Vec<[f64; LANES]>,
    /// Per lane: 1 while the guides act, 0 after the passage of the level.
    acting: [f64; LANES],
}

impl<'a, 'b, S, I, const D: usize, const M: usize> Group<'a, 'b, S, I, D, M>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
{
    fn new(ensemble: &'a GuidedEnsemble<'b, S, I, D, M>) -> Self {
        let zeros = vec![[0.0; LANES]; ensemble.guides.len()];
        let (chosen, lambdas, log_ratios) = (zeros.clone(), zeros.clone(), zeros);
        Self { ensemble, chosen, lambdas, log_ratios, acting: [1.0; LANES] }
    }

    /// Simulates the paths; returns their last states and largest responses.
    fn follow<W: Largest<D>>(
        &mut self,
        lives: &mut Lives,
        watch: &mut W,
    ) -> (LaneStates<D>, [f64; LANES]) {
        let GuidedEnsemble { dt, n_steps, seed, .. } = *self.ensemble;
        let (noise, first, n_active) = (Noise::new(seed), lives.first, lives.n_active);
        let mut x = [[0.0; LANES]; D];
        for lane in 0..n_active {
            let start = self.start(noise, first + lane as u64, lane);
            for (row, value) in x.iter_mut().zip(start) {
                row[lane] = value;
            }
        }
        if !all_finite(&x) {
            lives.bury(&mut x, 0, 0.0);
        }
        watch.start(first, &x);
        self.acting = [1.0; LANES];
        self.end_guides(&watch.largest());
        let streams = std::array::from_fn(|lane| first.wrapping_add(lane as u64));
        let level = SimdLevel::best();
        let noise = LaneNoise::<M>::new(level, seed, streams, [1.0; LANES]);
        let memory = std::array::from_fn(|_| I::Memory::default());
        level.run(Advance { group: self, noise, x: &mut x, memory, lives, watch });
        watch.output(0, n_steps as f64 * dt, &x, lives);
        (x, watch.largest())
    }

    /// Draws guide and start of a path.
    fn start(&mut self, noise: Noise, realisation: u64, lane: usize) -> [f64; D] {
        let GuidedEnsemble { mean, factor, guides, .. } = self.ensemble;
        let mut stream = noise.stream(Purpose::InitialDistribution, realisation);
        let mut uniform = stream.next_uniform();
        let mut normals = [0.0; D];
        stream.fill_normal(&mut normals);
        for (guide, chosen) in guides.iter().zip(&mut self.chosen) {
            let is_chosen = (0.0..guide.share).contains(&uniform);
            uniform -= guide.share;
            chosen[lane] = f64::from(u8::from(is_chosen));
            if is_chosen {
                for (normal, shift) in normals.iter_mut().zip(guide.start) {
                    *normal += shift;
                }
            }
        }
        for (guide, ratios) in guides.iter().zip(&mut self.log_ratios) {
            let terms = guide.start.iter().zip(&normals);
            ratios[lane] = terms.map(|(shift, n)| shift * (n - 0.5 * shift)).sum();
        }
        std::array::from_fn(|i| {
            mean[i] + factor[i].iter().zip(&normals).map(|(l, n)| l * n).sum::<f64>()
        })
    }
}

/// The steps of a group.
struct Advance<'g, 'a, 'b, S: ?Sized, I, W, Memory, const D: usize, const M: usize> {
    group: &'g mut Group<'a, 'b, S, I, D, M>,
    noise: LaneNoise<M>,
    x: &'g mut LaneStates<D>,
    memory: [Memory; LANES],
    lives: &'g mut Lives,
    watch: &'g mut W,
}

impl<S, I, W, const D: usize, const M: usize> Work<f64>
    for Advance<'_, '_, '_, S, I, W, I::Memory, D, M>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
    W: Largest<D>,
{
    type Output = ();

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        let Self { group, mut noise, x, mut memory, lives, watch } = self;
        let GuidedEnsemble { system, integrator, dt, n_steps, .. } = *group.ensemble;
        let units = Deviations::UNITS;
        let mut dw = LaneIncrements::ZERO;
        let mut before = *x;
        for k in 0..n_steps {
            let (t, step) = (k as f64 * dt, k as u64);
            if I::USES_AREA {
                noise.next::<true>(&units, &mut dw);
                group.shift::<true>(k, x, &mut dw);
            } else {
                noise.next::<false>(&units, &mut dw);
                group.shift::<false>(k, x, &mut dw);
            }
            if W::EVERY_STEP {
                before = *x;
            }
            let mut failed = |lane, source| {
                lives.fail(lane, |realisation| Error::Step { realisation, step, t, source });
            };
            let joints = Joints {
                before: !W::EVERY_STEP && k > 0,
                after: !W::EVERY_STEP && k + 1 < n_steps,
            };
            integrator.step_lanes_joined(joints, system, t, dt, &dw, x, &mut memory, &mut failed);
            if !all_finite(x) {
                lives.bury(x, step + 1, t + dt);
            }
            if W::EVERY_STEP {
                watch.step((t, dt), &before, x);
                group.end_guides(&watch.largest());
            }
        }
    }
}

impl<S, I, const D: usize, const M: usize> Group<'_, '_, S, I, D, M>
where
    S: ?Sized,
{
    /// Ends the guides of the lanes whose largest response exceeds the level.
    ///
    /// The event is then known, so that the likelihood ratios may stop too: what follows would only scatter them.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    fn end_guides(&mut self, largest: &[f64; LANES]) {
        let level = self.ensemble.passage.map_or(f64::INFINITY, |(_, level)| level);
        for lane in 0..LANES {
            self.acting[lane] = if largest[lane] > level { 0.0 } else { self.acting[lane] };
        }
    }

    /// Shifts the normals of a step, adds to the likelihood ratios, and scales the normals to increments.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    fn shift<const USES_AREA: bool>(
        &mut self,
        k: usize,
        x: &LaneStates<D>,
        normals: &mut LaneIncrements<M>,
    ) {
        let GuidedEnsemble { dt, guides, .. } = *self.ensemble;
        let (acting, mut shifts) = (self.acting, LaneIncrements::<M>::ZERO);
        for ((guide, lambdas), chosen) in guides.iter().zip(&mut self.lambdas).zip(&self.chosen) {
            let Some(step) = guide.steps.get(k) else { continue };
            let limit = LARGEST_SHIFT / step.square::<USES_AREA>().sqrt();
            let mut b = [step.offset; LANES];
            for (coefficient, row) in step.state.iter().zip(x) {
                for lane in 0..LANES {
                    b[lane] += coefficient * row[lane];
                }
            }
            let mut own = [0.0; LANES];
            for lane in 0..LANES {
                let lambda = hazard(b[lane]);
                lambdas[lane] = acting[lane] * if lambda < limit { lambda } else { limit };
                own[lane] = chosen[lane] * lambdas[lane];
            }
            for m in 0..M {
                for lane in 0..LANES {
                    shifts.brownian[m][lane] += own[lane] * step.brownian[m];
                    if USES_AREA {
                        shifts.space_time_area[m][lane] += own[lane] * step.area[m];
                    }
                }
            }
        }
        for m in 0..M {
            for lane in 0..LANES {
                normals.brownian[m][lane] += shifts.brownian[m][lane];
                if USES_AREA {
                    normals.space_time_area[m][lane] += shifts.space_time_area[m][lane];
                }
            }
        }
        for ((guide, lambdas), ratios) in guides.iter().zip(&self.lambdas).zip(&mut self.log_ratios)
        {
            let Some(step) = guide.steps.get(k) else { continue };
            let half_square = 0.5 * step.square::<USES_AREA>();
            let mut along = [0.0; LANES];
            for m in 0..M {
                for lane in 0..LANES {
                    along[lane] += step.brownian[m] * normals.brownian[m][lane];
                    if USES_AREA {
                        along[lane] += step.area[m] * normals.space_time_area[m][lane];
                    }
                }
            }
            for lane in 0..LANES {
                ratios[lane] += lambdas[lane] * (along[lane] - lambdas[lane] * half_square);
            }
        }
        let (deviation, area_deviation) = (dt.sqrt(), (dt / 12.0).sqrt());
        for m in 0..M {
            for lane in 0..LANES {
                normals.brownian[m][lane] *= deviation;
                normals.space_time_area[m][lane] *= area_deviation;
            }
        }
    }
}
