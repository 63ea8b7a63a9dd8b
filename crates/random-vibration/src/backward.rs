//! Guides of paths from the backward function of a linearised system.

use sde_integrators::Guide;

use crate::normal_tail::upper_tail;
use crate::regression::{Pattern, Regression, Regressions};

/// Start of all paths: mean and factor of its covariance, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub(crate) mean: Vec<f64>,
    pub(crate) factor: Vec<f64>,
}

/// The steps of the paths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stepping {
    pub(crate) dt: f64,
    pub(crate) n_steps: usize,
    /// Number of steps for which a guide is held.
    pub(crate) hold: usize,
    /// Standard deviation of the response that the linearised system leaves out, over that of the response.
    pub(crate) unmodelled: f64,
}

/// Noise of a system with `M` motions, the same at every state.
pub(crate) struct Loads<'a> {
    pub(crate) n_motions: usize,
    /// Writes `g(t)`, row by row.
    pub(crate) noise: Box<NoiseAt<'a>>,
}

/// Writes `g(t)`, row by row.
type NoiseAt<'a> = dyn Fn(f64, &mut [f64]) + Sync + 'a;

impl Loads<'_> {
    /// `g^T a` at a time.
    fn of(&self, t: f64, a: &[f64], g: &mut [f64]) -> Vec<f64> {
        (self.noise)(t, g);
        let n = self.n_motions;
        (0..n).map(|m| a.iter().enumerate().map(|(i, a)| g[i * n + m] * a).sum()).collect()
    }
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
    states: Vec<f64>,
    constants: Vec<f64>,
    deviations: Vec<f64>,
    /// `d` of each step, for the increments and for the areas.
    directions: Vec<f64>,
}

impl Backward {
    /// That of a weighted sum of the states after `steps.n_steps`.
    pub(crate) fn new(
        loads: &Loads<'_>,
        regressions: &Regressions,
        strength: usize,
        weights: &[f64],
        Stepping { dt, n_steps, hold, unmodelled }: Stepping,
    ) -> Self {
        let (n, m) = (weights.len(), loads.n_motions);
        let n_blocks = n_steps.div_ceil(hold);
        let mut backward = Self {
            hold,
            unmodelled,
            n_states: n,
            n_motions: m,
            states: vec![0.0; n_blocks * n],
            constants: vec![0.0; n_blocks],
            deviations: vec![0.0; n_blocks],
            directions: vec![0.0; n_steps * 2 * m],
        };
        let (mut state, mut constant, mut variance) = (weights.to_vec(), 0.0, 0.0_f64);
        let mut before = state.clone();
        let (mut regression, mut g) = (Regression::default(), vec![0.0; n * m]);
        let mut term = [vec![0.0; n], vec![0.0; n]];
        let mut later = loads.of(n_steps as f64 * dt, &state, &mut g);
        for k in (0..n_steps).rev() {
            let t = k as f64 * dt;
            regressions.interpolate(strength, t + 0.5 * dt, &mut regression);
            before.copy_from_slice(&state);
            adjoint(&regressions.pattern, &regression.slope, &mut before, dt, &mut term);
            for i in 0..n {
                constant += dt * 0.5 * (before[i] + state[i]) * regression.constant[i];
            }
            state.copy_from_slice(&before);
            let earlier = loads.of(t, &state, &mut g);
            let direction = &mut backward.directions[2 * m * k..2 * m * (k + 1)];
            for (place, (earlier, later)) in earlier.iter().zip(&later).enumerate() {
                direction[place] = 0.5 * (earlier + later) * dt.sqrt();
                direction[m + place] = (earlier - later) * (dt / 12.0).sqrt();
                let (w, h) = (direction[place], direction[m + place]);
                variance += w * w + h * h;
            }
            later = earlier;
            if k.is_multiple_of(hold) {
                let block = k / hold;
                backward.states[block * n..(block + 1) * n].copy_from_slice(&state);
                backward.constants[block] = constant;
                backward.deviations[block] = variance.sqrt();
            }
        }
        backward
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
        let shift = if b < -30.0 { -b } else { density(b) / upper_tail(-b) };
        let part = |slope: f64| if deviation > 0.0 { shift * slope / deviation } else { 0.0 };
        let start = slopes.into_iter().map(part).collect();
        let (n, of_step) = (self.n_states, 2 * self.n_motions);
        let mut feedback = Vec::with_capacity(self.constants.len() * (n + 1));
        let mut directions = Vec::with_capacity(self.directions.len());
        for (block, (deviation, constant)) in
            self.deviations.iter().zip(&self.constants).enumerate()
        {
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
        Guide { share, start, hold: self.hold, level, feedback, directions }
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

/// Replaces `a` by `exp(A^T h) a`, by its series to fourth order.
fn adjoint(pattern: &Pattern, slope: &[f64], a: &mut [f64], h: f64, term: &mut [Vec<f64>; 2]) {
    let [term, next] = term;
    term.copy_from_slice(a);
    for order in 1..=4 {
        next.fill(0.0);
        for (&(i, j), value) in pattern.iter().zip(slope) {
            next[j] += value * term[i];
        }
        for (value, (term, next)) in a.iter_mut().zip(term.iter_mut().zip(next.iter())) {
            *term = next * h / f64::from(order);
            *value += *term;
        }
    }
}

fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}
