//! The formulas of a material at a state that is taken for certain: what the paper differentiates.

use crate::observed::Observed;

/// A state in numbers, without its history: what [`Material::at_local_state`](super::Material::at_local_state) takes for
/// certain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalState {
    /// `V/V_0`.
    pub volume: f64,
    /// The pressure that the history has led to (stress).
    pub pressure: f64,
    /// What else is seen of it.
    pub observed: Observed<f64>,
}

/// Pressure and flow stress by the formulas of a material, as functions of its parameters alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalResponse<S> {
    /// The pressure (stress).
    pub pressure: S,
    /// The flow stress, where something yields.
    pub flow: Option<LocalFlow<S>>,
}

/// A flow stress at a certain plastic strain, rate and temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFlow<S> {
    /// `sigma_y` (stress).
    pub stress: S,
    /// `H`, its derivative by the plastic strain at the centre of the parameters; infinite at no plastic strain (stress).
    pub hardening_modulus: f64,
    /// `G` (stress).
    pub shear_modulus: f64,
}
