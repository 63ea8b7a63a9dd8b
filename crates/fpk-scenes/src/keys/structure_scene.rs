//! Structures that a scene can name, alone or behind a filter, and modulating functions of their noise.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vibrating_systems::Error;
use vibrating_systems::{
    BoucWen, BoucWenParameters, Duffing, DuffingParameters, LinearOscillator,
    LinearOscillatorParameters, TabulatedWindow, TwoStorey, TwoStoreyParameters, ViscousDamper,
    ViscousDamperParameters, Window,
};

/// A structure in its first mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StructureScene {
    /// `w`, the natural circular frequency (rad/s).
    pub natural_frequency: f64,
    /// `xi`, the damping over the critical one (no unit).
    pub damping_ratio: f64,
    /// `S_0`, the diffusion of the velocity at `a = 1` (m^2/s^3).
    pub noise_intensity: f64,
    /// `a(t)`, the modulating function of the noise.
    pub window: WindowScene,
}

/// A structure with a nonlinear viscous damper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamperScene {
    /// The structure without the damper.
    pub structure: StructureScene,
    /// `eta`, the force of the damper over the mass (m/s^2 per (m/s)^alpha).
    pub damper_coefficient: f64,
    /// `alpha`, the power of the velocity in that force (no unit).
    pub damper_exponent: f64,
}

/// An oscillator with a cubic spring.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DuffingScene {
    /// The oscillator without its cubic spring.
    pub structure: StructureScene,
    /// `epsilon`, the cubic part of the spring (1/m^2).
    pub cubic_stiffness: f64,
}

/// A hysteretic oscillator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoucWenScene {
    /// `omega_0`, the natural circular frequency before yielding (rad/s).
    pub natural_frequency: f64,
    /// `xi`, the damping over the critical one (no unit).
    pub damping_ratio: f64,
    /// `alpha`, the share of the linear stiffness, from 0 to 1 (no unit).
    pub hardening: f64,
    /// `A`, the slope of `z` over `q` at `z = 0` (no unit).
    pub initial_slope: f64,
    /// `beta`, which widens the loop (1/m^n).
    pub beta: f64,
    /// `gamma`, which shapes the loop (1/m^n).
    pub gamma: f64,
    /// `n`, the sharpness of yielding (no unit).
    pub exponent: f64,
    /// `S_0`, the diffusion of the velocity at `a = 1` (m^2/s^3).
    pub noise_intensity: f64,
    /// `a(t)`, the modulating function of the noise.
    pub window: WindowScene,
}

/// A building of two storeys; lists are ordered from the lower storey.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwoStoreyScene {
    /// `m_1, m_2`, the masses of the floors (kg).
    pub mass: [f64; 2],
    /// `k_1, k_2`, the stiffness of the storeys (N/m).
    pub stiffness: [f64; 2],
    /// `c_1, c_2`, the damping of the storeys (N s/m).
    pub damping: [f64; 2],
    /// `eta_1, eta_2`, the dampers in the storeys, 0 for none (N per (m/s)^alpha).
    pub damper_coefficient: [f64; 2],
    /// `alpha`, the power of the velocity in their force (no unit).
    pub damper_exponent: f64,
    /// `S_0`, the intensity of the ground acceleration (m^2/s^3).
    pub noise_intensity: f64,
    /// `a(t)`, the modulating function of the noise.
    pub window: WindowScene,
}

/// The modulating function `a(t)` of a noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Tabulated(vec![[0.0, 0.0], [2.0, 1.0], [6.0, 0.2]]))]
#[schemars(example = Self::RisePlateauDecay { rise_exponent: 2.0, rise_end: 2.0, decay_rate: 0.5, decay_start: 6.0 })]
#[schemars(example = Self::SinglePeak { peak: 1.0, peak_time: 2.0 })]
pub enum WindowScene {
    /// `a = 1` at all times.
    #[default]
    Stationary,
    /// Rise, plateau, exponential decay (Canor & Denoël 2013, eq 27).
    RisePlateauDecay {
        /// `n_1`, the power of the rise (no unit).
        rise_exponent: f64,
        /// `t_1`, the end of the rise (s).
        rise_end: f64,
        /// `n_2`, the rate of the decay (1/s).
        decay_rate: f64,
        /// `t_2`, the beginning of the decay (s).
        decay_start: f64,
    },
    /// Rise to one peak, and decay (Canor & Denoël 2013, eq 29).
    SinglePeak {
        /// `f_max`, the value at the peak (no unit).
        peak: f64,
        /// `t_max`, the time of the peak (s).
        peak_time: f64,
    },
    /// Piecewise linear between rows `[t, a]`, `t` increasing (s and no unit).
    Tabulated(Vec<[f64; 2]>),
}

impl StructureScene {
    pub(crate) fn parameters(&self) -> Result<LinearOscillatorParameters, Error> {
        let &Self { natural_frequency, damping_ratio, noise_intensity, ref window } = self;
        let window = window.build()?;
        Ok(LinearOscillatorParameters { natural_frequency, damping_ratio, noise_intensity, window })
    }

    pub(crate) fn build(&self) -> Result<LinearOscillator, Error> {
        LinearOscillator::new(self.parameters()?)
    }
}

impl DamperScene {
    pub(crate) fn build(&self) -> Result<ViscousDamper, Error> {
        let &Self { ref structure, damper_coefficient, damper_exponent } = self;
        let structure = structure.parameters()?;
        ViscousDamper::new(ViscousDamperParameters {
            structure,
            damper_coefficient,
            damper_exponent,
        })
    }
}

impl DuffingScene {
    pub(crate) fn build(&self) -> Result<Duffing, Error> {
        let &Self { ref structure, cubic_stiffness } = self;
        Duffing::new(DuffingParameters { structure: structure.parameters()?, cubic_stiffness })
    }
}

impl BoucWenScene {
    pub(crate) fn build(&self) -> Result<BoucWen, Error> {
        let &Self {
            natural_frequency,
            damping_ratio,
            hardening,
            initial_slope,
            beta,
            gamma,
            exponent,
            noise_intensity,
            ref window,
        } = self;
        BoucWen::new(BoucWenParameters {
            natural_frequency,
            damping_ratio,
            hardening,
            initial_slope,
            beta,
            gamma,
            exponent,
            noise_intensity,
            window: window.build()?,
        })
    }
}

impl TwoStoreyScene {
    pub(crate) fn build(&self) -> Result<TwoStorey, Error> {
        let &Self {
            mass,
            stiffness,
            damping,
            damper_coefficient,
            damper_exponent,
            noise_intensity,
            ref window,
        } = self;
        TwoStorey::new(TwoStoreyParameters {
            mass,
            stiffness,
            damping,
            damper_coefficient,
            damper_exponent,
            noise_intensity,
            window: window.build()?,
        })
    }
}

impl WindowScene {
    pub(crate) fn build(&self) -> Result<Window, Error> {
        Ok(match *self {
            Self::Stationary => Window::Stationary,
            Self::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start } => {
                Window::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start }
            }
            Self::SinglePeak { peak, peak_time } => Window::SinglePeak { peak, peak_time },
            Self::Tabulated(ref rows) => Window::Tabulated(TabulatedWindow::new(rows)?),
        })
    }
}
