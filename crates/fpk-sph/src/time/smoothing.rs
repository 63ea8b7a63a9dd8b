//! Smoothing lengths over a step.

use crate::time::state::State;

/// Smoothing lengths by eq 20 of Canor & Denoël 2013, frozen over a step:
///
/// $$ h_i(t_n) = h_{0i} \left( \frac{V_i(t_n)}{V_{0i}} \right)^{1/D} . $$
///
/// Density and volumes depend on each other through them, and the paper does not say at which time which is taken. Here the
/// lengths of a step are those of the volumes at the start of the step before it, at every stage: the order is 1. An estimator
/// that works on the lattice needs none; they are reported, and limit a Courant step.
#[derive(Debug)]
pub(crate) struct Smoothing {
    /// By eq 20 at the first stage.
    at_first: Vec<f64>,
    /// At every stage.
    pub(crate) lengths: Vec<f64>,
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
        Self { at_first: vec![0.0; n], lengths: vec![0.0; n] }
    }

    /// Starts a step with the volumes of its first stage.
    pub(crate) fn start<const D: usize>(&mut self, state: &State<D>, volume: &[f64]) {
        for (i, h) in self.at_first.iter_mut().enumerate() {
            *h = state.smoothing_ratios[i] * volume[i].powf(1.0 / D as f64);
        }
        self.lengths.copy_from_slice(&state.smoothing_lengths);
    }

    /// As [`Self::start`] for an estimator that works on the lattice, compiled for registers.
    pub(crate) fn start_on_lattice<const D: usize>(&mut self, state: &State<D>, volume: &[f64]) {
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

    /// Sets the lengths of the state at the end of a step.
    pub(crate) fn finish<const D: usize>(&self, state: &mut State<D>) {
        state.smoothing_lengths.copy_from_slice(&self.at_first);
    }
}
