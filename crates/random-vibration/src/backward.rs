//! Guides of paths from the backward function of a linearised system.

use sde_integrators::{Additive, Guidance, Guide, Sde};

use crate::normal_tail::upper_tail;
use crate::regression::Regressions;

/// Start of all paths: mean and Cholesky factor of its covariance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start<const D: usize> {
    pub(crate) mean: [f64; D],
    pub(crate) factor: [[f64; D]; D],
}

/// The steps of the paths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Steps {
    pub(crate) dt: f64,
    pub(crate) n_steps: usize,
}

/// The response `y = w . X` at the end of the steps, of the linearised system, given the state at the start of each step:
///
/// $$ E[y | X(t_k) = x] = a_k \cdot x + c_k, \qquad s_k^2 = \sum_{j \ge k} |d_j|^2, \qquad
///    \dot a = -A^T a, \quad \dot c = -a \cdot b, \quad a(t_n) = w . $$
///
/// Letters: `A` and `b` = slope and constant of the regression, `d_j` = derivatives of `y` by the normals of step `j`.
/// Over a step `e = g^T a` is linear in time, so that `d = ((e_j + e_(j+1))/2 sqrt(h), -(e_(j+1) - e_j) sqrt(h/12))`.
#[derive(Debug, Clone)]
pub(crate) struct Backward<const D: usize, const M: usize> {
    /// Per step.
    steps: Vec<Expected<D, M>>,
}

#[derive(Debug, Clone, Copy)]
struct Expected<const D: usize, const M: usize> {
    /// `a`.
    state: [f64; D],
    /// `c`.
    constant: f64,
    /// `d` for the increments and for the areas.
    brownian: [f64; M],
    area: [f64; M],
    /// `s`.
    deviation: f64,
}

impl<const D: usize, const M: usize> Backward<D, M> {
    pub(crate) fn new(
        system: &dyn Sde<D, M, Noise = Additive>,
        regressions: &Regressions<D>,
        strength: usize,
        weights: &[f64; D],
        Steps { dt, n_steps }: Steps,
    ) -> Self {
        // Additive noise: the same at every state.
        let anywhere = regressions.laws[0].mean;
        let loads = |t: f64, a: &[f64; D]| -> [f64; M] {
            let g = system.noise(t, &anywhere);
            std::array::from_fn(|m| (0..D).map(|i| g[i][m] * a[i]).sum())
        };
        let (mut state, mut constant, mut variance) = (*weights, 0.0, 0.0_f64);
        let mut later = loads(n_steps as f64 * dt, &state);
        let mut steps = Vec::with_capacity(n_steps);
        for k in (0..n_steps).rev() {
            let t = k as f64 * dt;
            let regression = regressions.at(strength, t + 0.5 * dt);
            let before = adjoint(&regression.slope, &state, dt);
            for i in 0..D {
                constant += dt * 0.5 * (before[i] + state[i]) * regression.constant[i];
            }
            state = before;
            let earlier = loads(t, &state);
            let brownian = std::array::from_fn(|m| 0.5 * (earlier[m] + later[m]) * dt.sqrt());
            let area = std::array::from_fn(|m| (earlier[m] - later[m]) * (dt / 12.0).sqrt());
            for m in 0..M {
                let (w, h): (&[f64; M], &[f64; M]) = (&brownian, &area);
                variance += w[m] * w[m] + h[m] * h[m];
            }
            later = earlier;
            let deviation = variance.sqrt();
            steps.push(Expected { state, constant, brownian, area, deviation });
        }
        steps.reverse();
        Self { steps }
    }

    /// The guide towards `side y > threshold`.
    pub(crate) fn guide(
        &self,
        start: &Start<D>,
        side: f64,
        threshold: f64,
        share: f64,
    ) -> Guide<D, M> {
        let (slopes, b, deviation) = self.at_start(start, side, threshold);
        // The expectation of the normals of the start given the event; far out phi/Phi is -b within 1e-3.
        let shift = if b < -30.0 { -b } else { density(b) / upper_tail(-b) };
        let start =
            slopes.map(|slope| if deviation > 0.0 { shift * slope / deviation } else { 0.0 });
        let guidance = |step: &Expected<D, M>| {
            // Without noise ahead nothing can be guided.
            let inverse = if step.deviation > 0.0 { 1.0 / step.deviation } else { 0.0 };
            Guidance {
                state: step.state.map(|a| side * inverse * a),
                offset: inverse * (side * step.constant - threshold),
                brownian: step.brownian.map(|d| side * inverse * d),
                area: step.area.map(|d| side * inverse * d),
            }
        };
        Guide { share, start, steps: self.steps.iter().map(guidance).collect() }
    }

    /// Expected excess of `side y` over the threshold before the start, in standard deviations.
    pub(crate) fn reliability(&self, start: &Start<D>, side: f64, threshold: f64) -> f64 {
        self.at_start(start, side, threshold).1
    }

    /// Derivatives of `side y` by the normals of the start, its expected excess in deviations, and its deviation.
    fn at_start(&self, start: &Start<D>, side: f64, threshold: f64) -> ([f64; D], f64, f64) {
        let Some(first) = self.steps.first() else { return ([0.0; D], 0.0, 0.0) };
        let slopes: [f64; D] = std::array::from_fn(|k| {
            side * (0..D).map(|i| first.state[i] * start.factor[i][k]).sum::<f64>()
        });
        let variance = slopes.iter().map(|slope| slope * slope).sum::<f64>();
        let deviation = (variance + first.deviation * first.deviation).sqrt();
        let mean: f64 = first.state.iter().zip(&start.mean).map(|(a, m)| a * m).sum();
        let excess = side * (mean + first.constant) - threshold;
        (slopes, excess / deviation.max(f64::MIN_POSITIVE), deviation)
    }
}

/// `exp(A^T h) a`, by its series to fourth order.
fn adjoint<const D: usize>(slope: &[[f64; D]; D], a: &[f64; D], h: f64) -> [f64; D] {
    let (mut sum, mut term) = (*a, *a);
    for order in 1..=4 {
        let next: [f64; D] =
            std::array::from_fn(|j| (0..D).map(|i| slope[i][j] * term[i]).sum::<f64>());
        term = next.map(|value| value * h / f64::from(order));
        for (value, more) in sum.iter_mut().zip(term) {
            *value += more;
        }
    }
    sum
}

fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}
