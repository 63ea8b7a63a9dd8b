//! Guided paths: a feedback shifts the normals of a path towards an event, and likelihood ratios undo its effect.

use std::ops::Range;

use lanes::{Registers, SimdLevel, Work};

use crate::blocks::reduce_blocks;
use crate::error::Error;
use crate::follow::{LaneStates, Lives, Watch, all_finite};
use crate::integrator::{Integrator, Joints};
use crate::lane_increments::{Deviations, LANES, LaneIncrements, LaneNoise};
use crate::maximum::{Maximum, Response};
use crate::noise::{Noise, Purpose};

/// Largest shift of the normals of a step, in standard deviations.
///
/// Near the end of a guide a path that misses the event has no control left, and its shift would grow without bound.
const LARGEST_SHIFT: f64 = 4.0;

/// The guide of one step: its normals are shifted by `lambda(b) d` with `b = state . x + offset`.
///
/// $$ \lambda(b) = \varphi(b) / \Phi(b), \qquad |\lambda d| \le 4 . $$
///
/// Example: a linear response has the expected value `mu(x)` and the standard deviation `s`, given the state at the start
/// of the step. With `b = (mu(x) - T)/s` and the derivatives of the response by the normals over `s` as direction `d`, the
/// shift is the expectation of the normals given that the response exceeds `T`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guidance<const D: usize, const M: usize> {
    /// Coefficients of the state (1 per unit of each state).
    pub state: [f64; D],
    /// Constant term of `b` (no unit).
    pub offset: f64,
    /// `d`, for the normals of the increments `w` (no unit).
    pub brownian: [f64; M],
    /// `d`, for the normals of the areas `H` (no unit); ignored if the method does not use them.
    pub area: [f64; M],
}

/// A guide of paths: one component of a [`GuidedEnsemble`].
#[derive(Debug, Clone, PartialEq)]
pub struct Guide<const D: usize, const M: usize> {
    /// Probability that a path has this guide (no unit).
    pub share: f64,
    /// Shift of the normals of the start (no unit).
    pub start: [f64; D],
    /// Guides of the first steps; the path is free afterwards.
    pub steps: Vec<Guidance<D, M>>,
}

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
/// $$ E[F] = E_q[F w], \qquad w = \Big( c_0 + \sum_j c_j r_j \Big)^{-1}, \qquad
///    \ln r_j = \sum_k \Big( \theta_{jk} \cdot n_k - \tfrac12 |\theta_{jk}|^2 \Big), $$
///
/// with the shares `c`, the normals `n_k` of step `k` (and of the start), the shift `theta_jk` that guide `j` gives at
/// the state before the step, and `q` the mixture. A weight is at most `1/c_0`. The weights are exact for any guide and
/// any method, because they are those of the discrete normals; the guides determine the variance alone.
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
    /// Response whose maximum over the path is computed, if any.
    pub response: Option<&'a Response<'a, D>>,
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
    /// shares that are not positive or exceed 1 together; those of [`maxima`](crate::maxima) for the response; [`Error::TooFew`] for no realisations; a failed
    /// path, [`Error::Step`] or [`Error::NonFiniteState`], always the lowest.
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
            match self.response {
                Some(response) => {
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
        if let Some(response) = self.response {
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
    /// The largest responses since the start of the group.
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
}

impl<'a, 'b, S, I, const D: usize, const M: usize> Group<'a, 'b, S, I, D, M>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
{
    fn new(ensemble: &'a GuidedEnsemble<'b, S, I, D, M>) -> Self {
        let zeros = vec![[0.0; LANES]; ensemble.guides.len()];
        Self { ensemble, chosen: zeros.clone(), lambdas: zeros.clone(), log_ratios: zeros }
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
    W: Watch<D>,
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
            }
        }
    }
}

impl<S, I, const D: usize, const M: usize> Group<'_, '_, S, I, D, M>
where
    S: ?Sized,
{
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
        let mut shifts = LaneIncrements::<M>::ZERO;
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
                lambdas[lane] = if lambda < limit { lambda } else { limit };
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

impl<const D: usize, const M: usize> Guide<D, M> {
    /// A number that is not finite, if there is one.
    fn not_finite(&self) -> Option<f64> {
        let of_step = |step: &Guidance<D, M>| {
            let all = step.state.iter().chain(&step.brownian).chain(&step.area);
            all.copied().chain([step.offset]).find(|value| !value.is_finite())
        };
        let mut first = [self.share].into_iter().chain(self.start);
        first.find(|value| !value.is_finite()).or_else(|| self.steps.iter().find_map(of_step))
    }
}

impl<const D: usize, const M: usize> Guidance<D, M> {
    /// `|d|^2`.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    fn square<const USES_AREA: bool>(&self) -> f64 {
        let mut square = 0.0;
        for m in 0..M {
            square += self.brownian[m] * self.brownian[m];
            if USES_AREA {
                square += self.area[m] * self.area[m];
            }
        }
        square
    }
}

/// `phi(b)/Phi(b)` within a relative 1 %.
///
/// A guide needs no more: the weights use the same number. For `a = |b|` the ratio of Mills is
/// `R(a) = pi/(2 a + sqrt((pi - 2)^2 a^2 + 2 pi))` (Boyd 1959, Inequalities for Mills' ratio), which is exact at zero and for large `a`.
#[allow(clippy::inline_always, reason = "used in a dispatched function")]
#[inline(always)]
fn hazard(b: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    const STEEPNESS: f64 = (PI - 2.0) * (PI - 2.0);
    const PEAK: f64 = 0.398_942_280_401_432_7;
    let a = b.abs();
    let over_mills = (2.0 * a + (STEEPNESS * a * a + TAU).sqrt()) / PI;
    let density = PEAK * lanes::exp(-0.5 * a * a);
    let likely = density / (1.0 - density / over_mills);
    if b > 0.0 { likely } else { over_mills }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1/R(-b)` with the ratio of Mills `R(x)`, the integral of `exp(-x t - t^2/2)` over `t > 0`, by the midpoint rule.
    #[test]
    fn the_hazard_is_that_of_the_normal_distribution_within_one_per_cent() {
        let step = 1e-3;
        for k in -60..=60 {
            let b = 0.1 * f64::from(k);
            let term = |i: i32| {
                let t = (f64::from(i) + 0.5) * step;
                (b * t - 0.5 * t * t).exp()
            };
            let exact = 1.0 / ((0..20_000).map(term).sum::<f64>() * step);
            let off = hazard(b) / exact - 1.0;
            assert!(off.abs() < 0.01, "{b}: {} {exact}", hazard(b));
        }
        assert!((hazard(-1e3) / 1e3 - 1.0).abs() < 1e-5 && hazard(1e3).abs() < f64::MIN_POSITIVE);
    }
}
