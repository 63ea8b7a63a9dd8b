//! Systems whose number of states is known at run time, and their paths in lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::error::{Error, StepError};
use crate::integrator::Joints;
use crate::methods::lane_paths::LanePaths;
use crate::noise::lane_increments::{LANES, LaneIncrements};

/// A system of any number of states with additive noise of one Brownian motion,
///
/// $$ dX = f(t, X) dt + g(t) dB , $$
///
/// evaluated for `L` paths at a time: a row for each state, a column for each path. Compiled for the widest registers of
/// the machine where `drift` is `#[inline]` and its loops over columns have no branch.
pub trait LaneSde: Sync {
    /// Number of states.
    fn n_states(&self) -> usize;

    /// Writes `f(t, x)` of `L` paths (units of the states per time); every entry must be written.
    fn drift<const L: usize>(&self, t: f64, x: &[[f64; L]], drift: &mut [[f64; L]]);

    /// Writes `g(t)`, an entry for each state (unit of the state per square root of time).
    fn noise(&self, t: f64, g: &mut [f64]);

    /// Returns states to the set in which the system stays, after a step: the return mapping of plasticity.
    ///
    /// Nothing by default.
    fn return_to_admissible<const L: usize>(&self, x: &mut [[f64; L]]) {
        let _ = x;
    }
}

/// A nonlinear term of a drift: its row, and the two states on which it depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairTerm {
    /// State to whose rate the term belongs.
    pub row: usize,
    /// The states on which it depends.
    pub states: [usize; 2],
}

/// A [`LaneSde`] whose nonlinear terms depend on two states each,
///
/// $$ f_i(t, x) = \sum_j A_{ij} x_j + \sum_{k : i_k = i} \varphi_k(x_{a_k}, x_{b_k}) , $$
///
/// as hysteretic variables do, with kinks where one of the two is zero. Its statistical linearisation then takes integrals over
/// two states at a time, whatever their number.
pub trait PairwiseSde: LaneSde {
    /// The entries `(i, j, A_ij)` of the linear part that are not zero, by `i` and then `j`.
    fn linear_part(&self) -> Vec<(usize, usize, f64)>;

    /// The nonlinear terms.
    fn pair_terms(&self) -> Vec<PairTerm>;

    /// `varphi_k(a, b)` of a term by its index (unit of the state of its row per time).
    fn pair_term(&self, k: usize, a: f64, b: f64) -> f64;
}

/// Classical Runge-Kutta steps along the piecewise linear path of the noise,
///
/// $$ \dot x = f(t, x) + g(t) w/h \quad \text{over a step of length } h, $$
///
/// with `w` = increment of the Brownian motion. This is the discrete white noise of many benchmarks: a force of value `w/h`
/// constant over each step.
///
/// Order (additive noise): strong 1, weak 2, with the bias `(omega h)^2/12` in the variance of a lightly damped oscillator;
/// 4 without noise. It is stable for a lightly damped oscillator with `h omega < 2.8`.
///
/// Source: Wong and Zakai 1965, On the convergence of ordinary integrals to stochastic integrals.
#[derive(Debug)]
pub struct WongZakai<'a, S>(pub &'a S);

/// Buffers of a step of `L` paths.
#[derive(Debug, Clone)]
pub struct Stages<const L: usize> {
    /// State of a stage, its rate and the weighted sum of the rates.
    rows: [Vec<[f64; L]>; 3],
    /// `g` at the start, in the middle and at the end of a step, with its first time and length.
    noise: [Vec<f64>; 3],
}

impl<const L: usize> Stages<L> {
    fn new(n_states: usize) -> Self {
        let rows = [const { Vec::new() }; 3].map(|_: Vec<[f64; L]>| vec![[0.0; L]; n_states]);
        Self { rows, noise: [const { Vec::new() }; 3].map(|_: Vec<f64>| vec![0.0; n_states]) }
    }
}

impl<S: LaneSde> WongZakai<'_, S> {
    /// Advances `L` paths by a step with the increments `w`.
    #[inline(always)]
    fn advance<const L: usize>(
        &self,
        (t, h): (f64, f64),
        w: &[f64; L],
        x: &mut [[f64; L]],
        stages: &mut Stages<L>,
    ) {
        let Stages { rows: [stage, rate, sum], noise } = stages;
        // A failed path may have left what zero does not cancel.
        for row in sum.iter_mut() {
            row.fill(0.0);
        }
        for (place, g) in noise.iter_mut().enumerate() {
            self.0.noise(t + 0.5 * place as f64 * h, g);
        }
        let force = w.map(|w| w / h);
        stage.copy_from_slice(x);
        for (at, weight, ahead) in [(0_u8, 1.0, 0.5), (1, 2.0, 0.5), (1, 2.0, 1.0), (2, 1.0, 0.0)] {
            self.0.drift(t + 0.5 * f64::from(at) * h, stage, rate);
            let g = &noise[usize::from(at)];
            let (part, next) = (weight * h / 6.0, ahead * h);
            // The sum begins anew.
            let kept = if at == 0 { 0.0 } else { 1.0 };
            let rows = rate.iter_mut().zip(sum.iter_mut()).zip(stage.iter_mut());
            for (((rate, sum), stage), (x, g)) in rows.zip(x.iter().zip(g)) {
                // Few states have noise of their own.
                if g.abs() > 0.0 {
                    for lane in 0..L {
                        rate[lane] += g * force[lane];
                    }
                }
                for lane in 0..L {
                    sum[lane] = kept * sum[lane] + part * rate[lane];
                    stage[lane] = x[lane] + next * rate[lane];
                }
            }
        }
        for (row, sum) in x.iter_mut().zip(sum) {
            for lane in 0..L {
                row[lane] += sum[lane];
            }
        }
        self.0.return_to_admissible(x);
    }
}

impl<S: LaneSde> LanePaths<1> for WongZakai<'_, S> {
    type States = Vec<[f64; LANES]>;
    type Memory = Stages<LANES>;

    const USES_AREA: bool = false;

    fn start(&self) -> (Self::States, Self::Memory) {
        let n = self.0.n_states();
        (vec![[0.0; LANES]; n], Stages::new(n))
    }

    #[inline(always)]
    fn step(
        &self,
        _: Joints,
        t: f64,
        dt: f64,
        dw: &LaneIncrements<1>,
        x: &mut Self::States,
        memory: &mut Self::Memory,
        _: &mut dyn FnMut(usize, StepError),
    ) {
        self.advance((t, dt), &dw.brownian[0], x, memory);
    }
}

/// One path of a [`LaneSde`] by [`WongZakai`] steps, as a function of the normals that drive it.
#[derive(Debug)]
pub struct DrivenLanes<'a, S> {
    /// The system.
    pub system: &'a S,
    /// Step length.
    pub dt: f64,
}

impl<S: LaneSde> DrivenLanes<'_, S> {
    /// Computes the path from `x` with a normal for each step; `look` observes the state before and after every step.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for the start; [`Error::NotPositive`] for the step length; [`Error::NonFiniteState`], which
    /// reports realisation 0.
    pub fn run(
        &self,
        start: &[f64],
        normals: &[f64],
        mut look: impl FnMut(&[[f64; 1]], &[[f64; 1]]),
    ) -> Result<(), Error> {
        let (expected, value, dt) = (self.system.n_states(), start.len(), self.dt);
        if value != expected {
            let quantity = "states of the start";
            return Err(Error::WrongLength { quantity, value, expected });
        }
        if !(dt.is_finite() && dt > 0.0) {
            return Err(Error::NotPositive { quantity: "dt", value: dt });
        }
        let (mut stages, deviation) = (Stages::<1>::new(expected), dt.sqrt());
        let mut x: Vec<[f64; 1]> = start.iter().map(|&value| [value]).collect();
        let mut before = x.clone();
        for (k, normal) in normals.iter().enumerate() {
            before.copy_from_slice(&x);
            let t = k as f64 * dt;
            WongZakai(self.system).advance((t, dt), &[deviation * normal], &mut x, &mut stages);
            if let Some(component) = x.iter().position(|[value]| !value.is_finite()) {
                let (steps, t, value) = (k as u64 + 1, t + dt, x[component][0]);
                return Err(Error::NonFiniteState { realisation: 0, steps, t, component, value });
            }
            look(&before, &x);
        }
        Ok(())
    }
}
