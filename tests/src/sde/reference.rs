//! Reference data of `sde-integrators`, each from an independent code; the origin stands in each file.

use serde::Deserialize;

use crate::case::CaseError;

/// Largest stable `|l| h` in the mean square.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MeanSquare {
    /// `m^2/(2 |l|)`.
    pub rays: Vec<f64>,
    /// Ray by ray.
    pub euler_maruyama: Vec<f64>,
    /// Ray by ray.
    pub milstein: Vec<f64>,
    /// Ray by ray.
    pub heun: Vec<f64>,
    /// Number of stages, the value without noise, the value at the ray 0.999.
    pub sk_rock: Vec<(u64, f64, f64)>,
}

impl MeanSquare {
    /// Reads the file.
    ///
    /// # Errors
    /// That of the JSON.
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../reference/derived/sde/mean_square_stability.json");
        Ok(serde_json::from_str(text)?)
    }
}

/// Fractions of paths that explode.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Explosion {
    /// Paths per row.
    pub paths: u64,
    /// The end of the paths.
    pub end: f64,
    /// `sigma`, `h`, fraction.
    pub rows: Vec<(f64, f64, f64)>,
}

impl Explosion {
    /// Reads the file.
    ///
    /// # Errors
    /// That of the JSON.
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../reference/derived/sde/explosion.json");
        Ok(serde_json::from_str(text)?)
    }
}

/// Relative bias of `E[q^2]` of the oscillator with a viscous damper.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct OscillatorBias {
    /// By the id of the method: step length, bias, standard error; finest first.
    pub methods: std::collections::BTreeMap<String, Vec<(f64, f64, f64)>>,
}

impl OscillatorBias {
    /// Reads the file.
    ///
    /// # Errors
    /// That of the JSON.
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../reference/derived/sde/oscillator_bias.json");
        Ok(serde_json::from_str(text)?)
    }
}
