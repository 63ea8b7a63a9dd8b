//! The bias of the steps in first passages of a building, from pairs of paths.

use rayon::prelude::*;
use sde_integrators::{
    Accumulator, DrivenLanes, Error, LaneSde, Noise, Purpose, Response, StepDifference,
};
use vibrating_systems::ShearBuilding;

use super::scene::{BetweenScene, PassageScene};
use crate::run::step_bias::{Law, MeasuredAs, StepBias};

/// Number of pairs.
const PAIRS: u64 = 200;

/// The bias of the steps of a scene, of which the demand is the largest drift so far.
///
/// Both paths of a pair have one Brownian motion, and one of them half the step. Where drifts count at the ends of steps alone, the noise
/// is that of the whole step for both, as the scene asks, and only what Runge-Kutta leaves is a bias.
pub(super) fn of_passages(scene: &PassageScene, building: &ShearBuilding, seed: u64) -> StepBias {
    let (times, each) = (scene.times.list(), scene.steps_per_time());
    let responses = scene.responses(building);
    let pairs = Pairs {
        building,
        responses: &responses,
        n_steps: times.len() * each,
        each,
        dt: scene.times.every / each as f64,
        counts_at_ends: scene.response.between == BetweenScene::Endpoints,
        noise: Noise::new(seed),
    };
    let fundamental = building.natural_frequencies().first().copied().unwrap_or(f64::INFINITY);
    let is_linear = !building.is_hysteretic();
    let measured_as = MeasuredAs {
        is_linear,
        highest_threshold: scene.thresholds.iter().copied().fold(0.0, f64::max),
        // The steps have weak order 2, and 1 across the kinks of a loop.
        bias_over_difference: if is_linear { 4.0 / 3.0 } else { 2.0 },
        law: Law::Crossings { half_period: std::f64::consts::PI / fundamental },
    };
    StepBias::of_pairs(&times, measured_as, |amplitude| pairs.differences(amplitude))
}

struct Pairs<'a> {
    building: &'a ShearBuilding,
    responses: &'a [Response<'static>],
    n_steps: usize,
    /// Steps from one time to the next.
    each: usize,
    dt: f64,
    counts_at_ends: bool,
    noise: Noise,
}

impl Pairs<'_> {
    /// Per time what half the step changes of the mean square of the largest drift.
    fn differences(&self, amplitude: f64) -> Result<Vec<Vec<StepDifference>>, Error> {
        let pair = |k: u64| self.pair(k, amplitude);
        let pairs: Vec<[Vec<f64>; 2]> =
            (0..PAIRS).into_par_iter().map(pair).collect::<Result<_, _>>()?;
        let at = |k: usize| -> Result<Vec<StepDifference>, Error> {
            let (mut difference, mut value) = (Accumulator::default(), Accumulator::default());
            for [whole, half] in &pairs {
                value.push(half[k].powi(2));
                difference.push(half[k].powi(2) - whole[k].powi(2));
            }
            let (difference, value) = (difference.estimate()?, value.estimate()?);
            Ok(vec![StepDifference { difference, value }])
        };
        (0..self.n_steps / self.each).map(at).collect()
    }

    /// The largest drift up to each time, by the steps of the scene and by half of them.
    fn pair(&self, k: u64, amplitude: f64) -> Result<[Vec<f64>; 2], Error> {
        let half_root = std::f64::consts::FRAC_1_SQRT_2;
        // Those of paths of an ensemble begin at realisation 0.
        let mut stream = self.noise.stream(Purpose::Path, u64::MAX - k);
        let mut short = vec![0.0; 2 * self.n_steps];
        stream.fill_normal(&mut short);
        for normal in &mut short {
            *normal *= amplitude;
        }
        let whole: Vec<f64> = short.chunks(2).map(|two| half_root * (two[0] + two[1])).collect();
        if self.counts_at_ends {
            for (two, one) in short.chunks_mut(2).zip(&whole) {
                two.fill(half_root * one);
            }
        }
        Ok([self.largest(&whole, 1)?, self.largest(&short, 2)?])
    }

    /// The largest drift up to each time, of steps of which some make one of the scene.
    fn largest(&self, normals: &[f64], parts: usize) -> Result<Vec<f64>, Error> {
        let dt = self.dt / parts as f64;
        let driven = DrivenLanes { system: self.building, dt };
        let (mut largest, mut step, mut found) = (0.0_f64, 0, Vec::new());
        driven.run(&vec![0.0; self.building.n_states()], normals, |before, after| {
            step += 1;
            if !self.counts_at_ends || step % parts == 0 {
                for response in self.responses {
                    let in_step = response.largest_in_step(dt, before, after).unwrap_or(f64::NAN);
                    // Not a number stays one, and the mean of the pairs then fails.
                    largest = if in_step > largest || in_step.is_nan() { in_step } else { largest };
                }
            }
            if step % (parts * self.each) == 0 {
                found.push(largest);
            }
        })?;
        Ok(found)
    }
}
