//! Guides of paths from the backward function of a linearised system.

use sde_integrators::{Guide, normal_probability};

use crate::guides::regression::RunningLaw;

/// Part of the variance of a response that is left to chance before its guide acts: a guide to a response that forgets its
/// past need not act from the start.
const FORGOTTEN: f64 = 1e-3;

/// Start of all paths: mean and factor of its covariance, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub(crate) mean: Vec<f64>,
    pub(crate) factor: Vec<f64>,
}

impl Start {
    /// A start at the mean of a law whose covariance is zero.
    pub(crate) fn of(rest: RunningLaw) -> Self {
        Self { mean: rest.mean, factor: rest.covariance }
    }
}

/// The steps of a guide.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stepping {
    pub(crate) dt: f64,
    /// Number of steps for which a guide is held.
    pub(crate) hold: usize,
    /// Standard deviation of the response that the linearised system leaves out, over that of the response.
    pub(crate) unmodelled: f64,
}

/// The response `y = w . X` at the end of the steps, of the linearised system, given the state at the start of each step:
///
/// $$ E[y | X(t_k) = x] = a_k \cdot x + c_k, \qquad s_k^2 = \sum_{j \ge k} |d_j|^2, \qquad
///    \dot a = -A^T a, \quad \dot c = -a \cdot b, \quad a(t_n) = w . $$
///
/// Letters: `A` and `b` = slope and constant of the regression, `d_j` = derivatives of `y` by the normals of step `j`.
/// Over a step `e = g^T a` is linear in time, so that `d = ((e_j + e_(j+1))/2 sqrt(h), -(e_(j+1) - e_j) sqrt(h/12))`.
#[derive(Debug, Clone)]
pub(crate) struct Backward {
    hold: usize,
    unmodelled: f64,
    n_states: usize,
    n_motions: usize,
    /// At the steps at which `lambda` is computed: `a`, `c` and `s`.
    pub(crate) states: Vec<f64>,
    pub(crate) constants: Vec<f64>,
    pub(crate) deviations: Vec<f64>,
    /// `d` of each step, for the increments and for the areas.
    pub(crate) directions: Vec<f64>,
}

impl Backward {
    /// Numbers of zero for a response after some steps.
    pub(crate) fn empty(
        (n_states, n_motions): (usize, usize),
        n_steps: usize,
        stepping: Stepping,
    ) -> Self {
        let Stepping { hold, unmodelled, .. } = stepping;
        let n_blocks = n_steps.div_ceil(hold);
        Self {
            hold,
            unmodelled,
            n_states,
            n_motions,
            states: vec![0.0; n_blocks * n_states],
            constants: vec![0.0; n_blocks],
            deviations: vec![0.0; n_blocks],
            directions: vec![0.0; n_steps * 2 * n_motions],
        }
    }

    /// The guide towards `side y > threshold`, which ends after the passage of a level.
    pub(crate) fn guide(
        &self,
        start: &Start,
        (side, threshold, level): (f64, f64, usize),
        share: f64,
    ) -> Guide {
        let (slopes, b, deviation) = self.at_start(start, side, threshold);
        // The expectation of the normals of the start given the event; far out phi/Phi is -b within 1e-3.
        let shift = if b < -30.0 { -b } else { density(b) / normal_probability(b) };
        let part = |slope: f64| if deviation > 0.0 { shift * slope / deviation } else { 0.0 };
        let first = self.first_block(deviation);
        let start = slopes.into_iter().map(|slope| if first > 0 { 0.0 } else { part(slope) });
        let (n, of_step) = (self.n_states, 2 * self.n_motions);
        let start = start.collect();
        let mut feedback = Vec::with_capacity((self.constants.len() - first) * (n + 1));
        let mut directions = Vec::with_capacity(self.directions.len());
        let blocks = self.deviations.iter().zip(&self.constants).enumerate();
        for (block, (deviation, constant)) in blocks.skip(first) {
            // Without noise ahead nothing can be guided.
            let deviation = self.with_unmodelled(*deviation);
            let inverse = if deviation > 0.0 { 1.0 / deviation } else { 0.0 };
            let state = &self.states[block * n..(block + 1) * n];
            feedback.extend(state.iter().map(|a| side * inverse * a));
            feedback.push(inverse * (side * constant - threshold));
            let first = block * self.hold * of_step;
            let last = (first + self.hold * of_step).min(self.directions.len());
            directions.extend(self.directions[first..last].iter().map(|d| side * inverse * d));
        }
        let from = first * self.hold;
        Guide { share, start, from, hold: self.hold, level, feedback, directions }
    }

    /// The block at which a guide begins to act: the last one whose state explains less than [`FORGOTTEN`] of the variance.
    fn first_block(&self, deviation: f64) -> usize {
        let least = (1.0 - FORGOTTEN).sqrt() * deviation;
        self.deviations.iter().take_while(|ahead| **ahead >= least).count().saturating_sub(1)
    }

    /// Number of coefficients of a guide.
    pub(crate) fn n_of_guide(&self, start: &Start) -> f64 {
        let (.., deviation) = self.at_start(start, 1.0, 0.0);
        let first = self.first_block(deviation);
        let of_blocks = (self.constants.len() - first) * (self.n_states + 1);
        let of_steps = self.directions.len() - first * self.hold * 2 * self.n_motions;
        (of_blocks + of_steps) as f64
    }

    /// The deviation of the response given the state, with what the linearised system leaves out.
    ///
    /// It keeps a guide from insisting on a response that the linearised system predicts badly.
    fn with_unmodelled(&self, deviation: f64) -> f64 {
        match self.deviations.first() {
            Some(first) if self.unmodelled > 0.0 => deviation.hypot(self.unmodelled * first),
            _ => deviation,
        }
    }

    /// Expected excess of `side y` over the threshold before the start, in standard deviations.
    pub(crate) fn reliability(&self, start: &Start, side: f64, threshold: f64) -> f64 {
        self.at_start(start, side, threshold).1
    }

    /// Probability that `side y` exceeds the threshold, before the start.
    pub(crate) fn likely(&self, start: &Start, side: f64, threshold: f64) -> f64 {
        normal_probability(self.reliability(start, side, threshold))
    }

    /// Derivatives of `side y` by the normals of the start, its expected excess in deviations, and its deviation.
    fn at_start(&self, start: &Start, side: f64, threshold: f64) -> (Vec<f64>, f64, f64) {
        let n = self.n_states;
        let Some(&first) = self.deviations.first() else { return (vec![0.0; n], 0.0, 0.0) };
        let a = &self.states[..n];
        let slope = |k: usize| -> f64 {
            side * a.iter().enumerate().map(|(i, a)| a * start.factor[i * n + k]).sum::<f64>()
        };
        let slopes: Vec<f64> = (0..n).map(slope).collect();
        let variance = slopes.iter().map(|slope| slope * slope).sum::<f64>();
        let deviation = (variance + first * first).sqrt();
        let mean: f64 = a.iter().zip(&start.mean).map(|(a, m)| a * m).sum();
        let excess = side * (mean + self.constants[0]) - threshold;
        (slopes, excess / deviation.max(f64::MIN_POSITIVE), deviation)
    }
}

fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}
