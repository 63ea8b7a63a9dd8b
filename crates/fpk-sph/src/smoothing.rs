//! Smoothing lengths at the stages of a step.

use crate::state::State;

/// Smoothing lengths at the stages of a step: by eq 20 where there are volumes, and from there at the estimator's rates.
///
/// $$ h_i(t_n + s) = h_i(t_n) \exp\left( \ell \tanh\frac{r_i s}{\ell} \right), \qquad
/// h_i(t_n) = h_{0i} \left( \frac{V_i(t_n)}{V_{0i}} \right)^{1/D}, \qquad \ell = \ln 2 . $$
///
/// At the end of the step eq 20 has the volumes of the last stage, which lies there (Heun, Runge-Kutta 4), or the rate goes on to
/// the end. An error `e` of the lengths with which volumes were made becomes `c e` with `0 <= c < 1`, and a step adds
/// `O(dt^2)`: the lengths have the order 2. The limit of a factor of 2 in a step holds rates of particles at the rim, whose
/// neighbours do not move alike; elsewhere it is an error of the third order.
///
/// Where the estimator gives no rates, the lengths of a step are those of eq 20 at the start of the step before it, at every
/// stage: the order is 1.
#[derive(Debug)]
pub(crate) struct Smoothing {
    /// By eq 20 at the first stage.
    at_first: Vec<f64>,
    /// `d log h / dt` there (1 per unit of time); empty where the estimator gives none.
    pub(crate) rates: Vec<f64>,
    /// At the stage.
    pub(crate) lengths: Vec<f64>,
    /// Time of the stage since the start of the step.
    elapsed: f64,
}

/// The logarithm of the largest change of a smoothing length within a step.
const MOST_CHANGE: f64 = std::f64::consts::LN_2;

/// `exp(l tanh(x / l))`: `exp(x)` to third order, and never more than a factor of 2.
fn growth(x: f64) -> f64 {
    (MOST_CHANGE * (x / MOST_CHANGE).tanh()).exp()
}

/// `V^(1/D)`, compiled for registers.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for registers")]
#[inline(always)]
fn root<const D: usize>(volume: f64) -> f64 {
    match D {
        1 => volume,
        2 => volume.sqrt(),
        _ => simd_lanes::power(volume, 1.0 / D as f64),
    }
}

impl Smoothing {
    pub(crate) fn new(n: usize) -> Self {
        let (at_first, rates) = (vec![0.0; n], Vec::with_capacity(n));
        Self { at_first, rates, lengths: vec![0.0; n], elapsed: 0.0 }
    }

    /// Starts a step with the volumes of its first stage.
    pub(crate) fn start<const D: usize>(&mut self, state: &State<D>, volume: &[f64]) {
        self.elapsed = 0.0;
        self.lengths.copy_from_slice(&state.smoothing_lengths);
        for (i, h) in self.at_first.iter_mut().enumerate() {
            *h = state.smoothing_by_volume(i, volume[i]);
        }
    }

    /// Starts a step of an estimator that works on the lattice: its lengths are reported and limit a Courant step, and no
    /// neighbour is searched by them.
    pub(crate) fn start_on_lattice<const D: usize>(&mut self, state: &State<D>, volume: &[f64]) {
        self.elapsed = 0.0;
        self.rates.clear();
        let n = self.at_first.len();
        let (ratios, volume) = (&state.smoothing_ratios[..n], &volume[..n]);
        simd_lanes::dispatch(
            #[inline(always)]
            || {
                for (i, h) in self.at_first.iter_mut().enumerate() {
                    *h = ratios[i] * root::<D>(volume[i]);
                }
            },
        );
        self.lengths.copy_from_slice(&state.smoothing_lengths);
    }

    /// Sets the lengths to those of a stage, `elapsed` after the start of the step.
    pub(crate) fn follow(&mut self, elapsed: f64) {
        self.elapsed = elapsed;
        for ((h, first), rate) in self.lengths.iter_mut().zip(&self.at_first).zip(&self.rates) {
            *h = first * growth(rate * elapsed);
        }
    }

    /// Sets the lengths of the state to those at the end of a step of length `dt`, with the volumes of its last stage.
    pub(crate) fn finish<const D: usize>(&self, state: &mut State<D>, volume: &[f64], dt: f64) {
        if self.rates.is_empty() {
            state.smoothing_lengths.copy_from_slice(&self.at_first);
            return;
        }
        for (i, rate) in self.rates.iter().enumerate() {
            let last = state.smoothing_by_volume(i, volume[i]);
            state.smoothing_lengths[i] = last * growth(rate * (dt - self.elapsed));
        }
    }
}
