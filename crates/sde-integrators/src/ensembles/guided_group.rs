//! A group of guided paths in lanes: its start, its steps and its likelihood ratios.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Registers, SimdLevel, Work};

use crate::ensembles::follow::{Lives, all_finite};
use crate::ensembles::guide::{Guide, LARGEST_SHIFT, hazard};
use crate::ensembles::guided_watch::Largest;
use crate::error::Error;
use crate::integrator::Joints;
use crate::methods::lane_paths::LanePaths;
use crate::noise::lane_increments::{LANES, LaneIncrements, LaneNoise};
use crate::noise::streams::{Noise, Purpose};

/// What all groups have in common; see [`GuidedEnsemble`](crate::GuidedEnsemble).
#[derive(Debug)]
pub(crate) struct Shared<'a, P> {
    pub(crate) paths: &'a P,
    pub(crate) mean: &'a [f64],
    pub(crate) factor: &'a [f64],
    pub(crate) dt: f64,
    pub(crate) n_steps: usize,
    pub(crate) guides: &'a [Guide],
    pub(crate) levels: &'a [f64],
    pub(crate) seed: u64,
    /// First realisation of the block, and its number of paths: the strata of the choice of guides.
    pub(crate) strata: (u64, u64),
}

/// Number of steps of a passage that has not happened.
const NEVER: u64 = u64::MAX;

/// [`LANES`] paths, with buffers that are reused.
pub(crate) struct Group<'a, P> {
    shared: Shared<'a, P>,
    /// Per guide and lane: 1 if the path has the guide, otherwise 0.
    chosen: Vec<[f64; LANES]>,
    /// Per guide and lane: `phi/Phi` since it was last computed.
    hazards: Vec<[f64; LANES]>,
    /// Per guide and lane: `lambda` of the current step.
    lambdas: Vec<[f64; LANES]>,
    /// Per guide and lane: `ln r`.
    log_ratios: Vec<[f64; LANES]>,
    /// Per level and lane: 1 while the guides of the level act, 0 after its passage. Without a level it has one row.
    acting: Vec<[f64; LANES]>,
    /// Per level and lane: number of steps up to its passage.
    passed: Vec<[u64; LANES]>,
    /// Per level, guide and lane: `ln r` at the passage.
    at_passage: Vec<[f64; LANES]>,
    /// Normals of a start.
    normals: Vec<f64>,
}

impl<'a, P> Group<'a, P> {
    pub(crate) fn new(shared: Shared<'a, P>) -> Self {
        let (n_guides, n_levels) = (shared.guides.len(), shared.levels.len());
        let zeros = vec![[0.0; LANES]; n_guides];
        Self {
            chosen: zeros.clone(),
            hazards: zeros.clone(),
            lambdas: zeros.clone(),
            log_ratios: zeros,
            acting: vec![[1.0; LANES]; n_levels.max(1)],
            passed: vec![[NEVER; LANES]; n_levels],
            at_passage: vec![[0.0; LANES]; n_levels * n_guides],
            normals: vec![0.0; shared.mean.len()],
            shared,
        }
    }

    /// Number of steps up to the passage of a level by a path, if it passes it.
    pub(crate) fn passage(&self, level: usize, lane: usize) -> Option<u64> {
        let steps = self.passed[level][lane];
        (steps != NEVER).then_some(steps)
    }

    /// `ln r` of a path: of all guides at the end, then of all guides at the passage of each level.
    pub(crate) fn ratios(&self, lane: usize, ratios: &mut [f64]) {
        let rows = self.log_ratios.iter().chain(&self.at_passage);
        for (value, row) in ratios.iter_mut().zip(rows) {
            *value = row[lane];
        }
    }

    /// Draws guide and start of a path, and writes the start into its lane.
    fn start(&mut self, noise: Noise, realisation: u64, lane: usize, x: &mut [[f64; LANES]]) {
        let Shared { mean, factor, guides, strata: (first, n), .. } = self.shared;
        let mut stream = noise.stream(Purpose::InitialDistribution, realisation);
        let stratum = realisation.wrapping_sub(first) as f64;
        let mut uniform = (stratum + stream.next_uniform()) / n as f64;
        stream.fill_normal(&mut self.normals);
        for (guide, chosen) in guides.iter().zip(&mut self.chosen) {
            let is_chosen = (0.0..guide.share).contains(&uniform);
            uniform -= guide.share;
            chosen[lane] = f64::from(u8::from(is_chosen));
            if is_chosen {
                for (normal, shift) in self.normals.iter_mut().zip(&guide.start) {
                    *normal += shift;
                }
            }
        }
        for (guide, ratios) in guides.iter().zip(&mut self.log_ratios) {
            let terms = guide.start.iter().zip(&self.normals);
            ratios[lane] = terms.map(|(shift, n)| shift * (n - 0.5 * shift)).sum();
        }
        let rows = factor.chunks_exact(mean.len().max(1));
        for ((row, mean), factors) in x.iter_mut().zip(mean).zip(rows) {
            let terms = factors.iter().zip(&self.normals);
            row[lane] = mean + terms.map(|(l, n)| l * n).sum::<f64>();
        }
    }

    /// Records the levels that the largest responses exceed after this many steps, and ends the guides to them.
    #[inline(always)]
    fn pass(&mut self, steps: u64, largest: &[f64; LANES]) {
        for (index, level) in self.shared.levels.iter().enumerate() {
            let mut is_new = false;
            for lane in 0..LANES {
                is_new |= largest[lane] > *level && self.passed[index][lane] == NEVER;
            }
            if is_new {
                self.record(index, steps, largest);
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn record(&mut self, index: usize, steps: u64, largest: &[f64; LANES]) {
        let n_guides = self.log_ratios.len();
        let at_passage = &mut self.at_passage[index * n_guides..(index + 1) * n_guides];
        for lane in 0..LANES {
            if largest[lane] > self.shared.levels[index] && self.passed[index][lane] == NEVER {
                self.passed[index][lane] = steps;
                self.acting[index][lane] = 0.0;
                for (kept, now) in at_passage.iter_mut().zip(&self.log_ratios) {
                    kept[lane] = now[lane];
                }
            }
        }
    }

    /// Shifts the normals of a step, adds to the likelihood ratios, and scales the normals to increments.
    #[inline(always)]
    fn shift<const USES_AREA: bool, const M: usize>(
        &mut self,
        k: usize,
        x: &[[f64; LANES]],
        normals: &mut LaneIncrements<M>,
    ) {
        let Shared { dt, guides, .. } = self.shared;
        let mut shifts = LaneIncrements::<M>::ZERO;
        for (j, guide) in guides.iter().enumerate() {
            let Some(direction) = guide.direction::<M>(k) else { continue };
            if let Some((coefficients, offset)) = guide.feedback_at(k, x.len()) {
                let mut b = [offset; LANES];
                for (coefficient, row) in coefficients.iter().zip(x) {
                    for lane in 0..LANES {
                        b[lane] += coefficient * row[lane];
                    }
                }
                for lane in 0..LANES {
                    self.hazards[j][lane] = hazard(b[lane]);
                }
            }
            let limit = LARGEST_SHIFT / direction.square::<USES_AREA>().sqrt();
            let (hazards, acting) = (&self.hazards[j], &self.acting[guide.level]);
            let (lambdas, chosen) = (&mut self.lambdas[j], &self.chosen[j]);
            let mut own = [0.0; LANES];
            for lane in 0..LANES {
                let lambda = hazards[lane];
                lambdas[lane] = acting[lane] * if lambda < limit { lambda } else { limit };
                own[lane] = chosen[lane] * lambdas[lane];
            }
            for m in 0..M {
                for lane in 0..LANES {
                    shifts.brownian[m][lane] += own[lane] * direction.brownian[m];
                    if USES_AREA {
                        shifts.space_time_area[m][lane] += own[lane] * direction.area[m];
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
        self.add_to_ratios::<USES_AREA, M>(k, normals);
        let (deviation, area_deviation) = (dt.sqrt(), (dt / 12.0).sqrt());
        for m in 0..M {
            for lane in 0..LANES {
                normals.brownian[m][lane] *= deviation;
                normals.space_time_area[m][lane] *= area_deviation;
            }
        }
    }

    /// Adds the shifted normals of a step to the likelihood ratios.
    #[inline(always)]
    fn add_to_ratios<const USES_AREA: bool, const M: usize>(
        &mut self,
        k: usize,
        normals: &LaneIncrements<M>,
    ) {
        let guides = self.shared.guides;
        for ((guide, lambdas), ratios) in guides.iter().zip(&self.lambdas).zip(&mut self.log_ratios)
        {
            let Some(direction) = guide.direction::<M>(k) else { continue };
            let half_square = 0.5 * direction.square::<USES_AREA>();
            let mut along = [0.0; LANES];
            for m in 0..M {
                for lane in 0..LANES {
                    along[lane] += direction.brownian[m] * normals.brownian[m][lane];
                    if USES_AREA {
                        along[lane] += direction.area[m] * normals.space_time_area[m][lane];
                    }
                }
            }
            for lane in 0..LANES {
                ratios[lane] += lambdas[lane] * (along[lane] - lambdas[lane] * half_square);
            }
        }
    }

    /// Simulates the paths; returns their last states and largest responses.
    pub(crate) fn follow<W: Largest, const M: usize>(
        &mut self,
        lives: &mut Lives,
        watch: &mut W,
    ) -> (P::States, [f64; LANES])
    where
        P: LanePaths<M>,
    {
        let Shared { paths, seed, .. } = self.shared;
        let (noise, first, n_active) = (Noise::new(seed), lives.first, lives.n_active);
        let (mut x, memory) = paths.start();
        for lane in 0..n_active {
            self.start(noise, first + lane as u64, lane, x.as_mut());
        }
        if !all_finite(x.as_ref()) {
            lives.bury(x.as_mut(), 0, 0.0);
        }
        watch.start(first, x.as_ref());
        self.acting.fill([1.0; LANES]);
        self.passed.fill([NEVER; LANES]);
        self.pass(0, &watch.largest());
        let streams = std::array::from_fn(|lane| first.wrapping_add(lane as u64));
        let level = SimdLevel::best();
        let noise = LaneNoise::<M>::new(level, seed, streams);
        level.run(Advance::<_, W, M> { group: self, noise, x: &mut x, memory, lives, watch });
        (x, watch.largest())
    }
}

/// The steps of a group.
struct Advance<'g, 'a, P: LanePaths<M>, W, const M: usize> {
    group: &'g mut Group<'a, P>,
    noise: LaneNoise<M>,
    x: &'g mut P::States,
    memory: P::Memory,
    lives: &'g mut Lives,
    watch: &'g mut W,
}

impl<P: LanePaths<M>, W: Largest, const M: usize> Work<f64> for Advance<'_, '_, P, W, M> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        let Self { group, mut noise, x, mut memory, lives, watch } = self;
        let Shared { paths, dt, n_steps, .. } = group.shared;
        let mut dw = LaneIncrements::ZERO;
        let mut before = x.clone();
        for k in 0..n_steps {
            let (t, step) = (k as f64 * dt, k as u64);
            if P::USES_AREA {
                noise.next::<true>(1.0, 1.0, &mut dw);
                group.shift::<true, M>(k, x.as_ref(), &mut dw);
            } else {
                noise.next::<false>(1.0, 1.0, &mut dw);
                group.shift::<false, M>(k, x.as_ref(), &mut dw);
            }
            if W::EVERY_STEP {
                before.as_mut().copy_from_slice(x.as_ref());
            }
            let mut failed = |lane, source| {
                lives.fail(lane, |realisation| Error::Step { realisation, step, t, source });
            };
            let joints = Joints {
                before: !W::EVERY_STEP && k > 0,
                after: !W::EVERY_STEP && k + 1 < n_steps,
            };
            paths.step(joints, t, dt, &dw, x, &mut memory, &mut failed);
            if !all_finite(x.as_ref()) {
                lives.bury(x.as_mut(), step + 1, t + dt);
            }
            if W::EVERY_STEP {
                watch.step((t, dt), before.as_ref(), x.as_ref());
                group.pass(step + 1, &watch.largest());
            }
        }
    }
}
