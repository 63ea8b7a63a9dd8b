//! The structures that a scene can name, alone or behind a filter, and the windows of their noise.

use fpk_sph::Error;
use fpk_sph::systems::{
    BoucWen, BoucWenParameters, LinearOscillator, LinearOscillatorParameters, TabulatedWindow,
    TwoStorey, TwoStoreyParameters, ViscousDamper, ViscousDamperParameters, Window,
};
use serde::{Deserialize, Serialize};

/// A structure in its first mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructureScene {
    /// `w` (rad/s).
    pub natural_frequency: f64,
    /// `xi`.
    pub damping_ratio: f64,
    /// `S_0`, the diffusion of the velocity at `a = 1`.
    pub noise_intensity: f64,
    /// `a(t)`.
    pub window: WindowScene,
}

/// A structure with a nonlinear viscous damper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DamperScene {
    /// The structure.
    pub structure: StructureScene,
    /// `eta`.
    pub damper_coefficient: f64,
    /// `alpha`.
    pub damper_exponent: f64,
}

/// A hysteretic oscillator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoucWenScene {
    /// `omega_0` (rad/s).
    pub natural_frequency: f64,
    /// `xi`.
    pub damping_ratio: f64,
    /// `alpha`, the share of the linear stiffness.
    pub hardening: f64,
    /// `A`.
    pub initial_slope: f64,
    /// `beta`.
    pub beta: f64,
    /// `gamma`.
    pub gamma: f64,
    /// `n`.
    pub exponent: f64,
    /// `S_0`.
    pub noise_intensity: f64,
    /// `a(t)`.
    pub window: WindowScene,
}

/// A building of two storeys; lists hold the lower storey first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwoStoreyScene {
    /// `m_1, m_2`.
    pub mass: [f64; 2],
    /// `k_1, k_2`.
    pub stiffness: [f64; 2],
    /// `c_1, c_2`.
    pub damping: [f64; 2],
    /// `eta_1, eta_2`; 0 for none.
    pub damper_coefficient: [f64; 2],
    /// `alpha`.
    pub damper_exponent: f64,
    /// `S_0` of the ground acceleration.
    pub noise_intensity: f64,
    /// `a(t)`.
    pub window: WindowScene,
}

/// The window of the noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WindowScene {
    /// `a = 1`.
    #[default]
    Stationary,
    /// Canor & Denoël 2013, eq 27.
    RisePlateauDecay {
        /// `n_1`.
        rise_exponent: f64,
        /// `t_1` (s).
        rise_end: f64,
        /// `n_2` (1/s).
        decay_rate: f64,
        /// `t_2` (s).
        decay_start: f64,
    },
    /// Canor & Denoël 2013, eq 29.
    SinglePeak {
        /// `f_max`.
        peak: f64,
        /// `t_max` (s).
        peak_time: f64,
    },
    /// Linear between rows `[t, a]`.
    Tabulated(Vec<[f64; 2]>),
}

impl StructureScene {
    pub(super) fn parameters(&self) -> Result<LinearOscillatorParameters, Error> {
        let &Self { natural_frequency, damping_ratio, noise_intensity, ref window } = self;
        let window = window.build()?;
        Ok(LinearOscillatorParameters { natural_frequency, damping_ratio, noise_intensity, window })
    }

    pub(super) fn build(&self) -> Result<LinearOscillator, Error> {
        LinearOscillator::new(self.parameters()?)
    }
}

impl DamperScene {
    pub(super) fn build(&self) -> Result<ViscousDamper, Error> {
        let &Self { ref structure, damper_coefficient, damper_exponent } = self;
        let structure = structure.parameters()?;
        ViscousDamper::new(ViscousDamperParameters {
            structure,
            damper_coefficient,
            damper_exponent,
        })
    }
}

impl BoucWenScene {
    pub(super) fn build(&self) -> Result<BoucWen, Error> {
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
    pub(super) fn build(&self) -> Result<TwoStorey, Error> {
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
    pub(super) fn build(&self) -> Result<Window, Error> {
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
