//! The linear oscillator under modulated white noise: the system whose answer is exact.

use sde_integrators::SecondOrder;

use crate::Window;
use crate::error::{Error, not_negative, positive};
use crate::oscillators::first_order::first_order;

/// A structure in its first mode.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "schema", serde(deny_unknown_fields), schemars(rename = "StructureScene"))]
pub struct LinearOscillatorParameters {
    /// `w > 0`, the natural circular frequency (rad/s).
    pub natural_frequency: f64,
    /// `xi >= 0`, the damping over the critical one (no unit).
    pub damping_ratio: f64,
    /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
    /// density per rad/s, a quarter of a one-sided one per Hz.
    pub noise_intensity: f64,
    /// `a(t)`, the modulating function of the noise.
    pub window: Window,
}

/// The linear oscillator
///
/// $$ \ddot q + 2 \xi \omega_0 \dot q + \omega_0^2 q = a(t) W(t), \qquad E[W(t) W(t+\tau)] = 2 S_0 \delta(\tau), $$
///
/// eq 26 of Canor & Denoël 2013 without its damper. State `(q, q')`; `D_22 = S_0 a^2`, all other entries zero. Gaussian
/// at all times, with moments from the Lyapunov equation.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearOscillator {
    parameters: LinearOscillatorParameters,
}

impl LinearOscillator {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the frequency, [`Error::Negative`] for damping and noise, [`Error::NotFinite`], and those of
    /// [`Window::check`].
    pub fn new(parameters: LinearOscillatorParameters) -> Result<Self, Error> {
        positive("natural_frequency", parameters.natural_frequency)?;
        not_negative("damping_ratio", parameters.damping_ratio)?;
        not_negative("noise_intensity", parameters.noise_intensity)?;
        parameters.window.check()?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &LinearOscillatorParameters {
        &self.parameters
    }

    /// `2 pi / omega_0`, the natural period (time).
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.parameters.natural_frequency
    }

    /// `a(t) sqrt(2 S_0)`, what multiplies `dB`.
    #[inline]
    fn noise_amplitude(&self, t: f64) -> f64 {
        self.parameters.window.noise_amplitude(t, self.parameters.noise_intensity)
    }
}

first_order!(LinearOscillator);

impl SecondOrder<1, 1> for LinearOscillator {
    #[inline]
    fn natural_frequency(&self) -> [f64; 1] {
        [self.parameters.natural_frequency]
    }

    #[inline]
    fn linear_damping(&self) -> [f64; 1] {
        [2.0 * self.parameters.damping_ratio * self.parameters.natural_frequency]
    }

    #[inline]
    fn remaining_acceleration(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    #[inline]
    fn remaining_flow(&self, _: f64, _: f64, _: &[f64; 1], _: &mut [f64; 1]) {}

    #[inline]
    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        [[self.noise_amplitude(t)]]
    }
}
