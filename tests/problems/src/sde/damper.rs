//! The viscous damper under stationary noise.

use vibrating_systems::{
    LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters, Window,
};

use crate::context::CaseError;

/// The structure of the paper with its damper, under noise that does not fade.
pub fn viscous_damper_at_rest() -> Result<ViscousDamper, CaseError> {
    let structure = LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.01,
        noise_intensity: 0.2,
        window: Window::Stationary,
    };
    let parameters =
        ViscousDamperParameters { structure, damper_coefficient: 0.25, damper_exponent: 0.35 };
    Ok(ViscousDamper::new(parameters)?)
}
