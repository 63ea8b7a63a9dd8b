//! Reference data of `sde-integrators`, each from an independent code; each file states its origin.

use serde::Deserialize;

use crate::context::CaseError;

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
}

impl MeanSquare {
    /// Reads the file.
    pub fn read() -> Result<Self, CaseError> {
        let text =
            include_str!("../../../../tests/reference/derived/sde/mean_square_stability.json");
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
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/reference/derived/sde/explosion.json");
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
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/reference/derived/sde/oscillator_bias.json");
        Ok(serde_json::from_str(text)?)
    }
}

/// Second moments and an exceedance of the oscillator with a viscous damper under the windowed noise of the paper.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct OscillatorEnsemble {
    /// Paths behind every row.
    pub paths: u64,
    /// `t`, `E[q^2]`, its standard error, `E[v^2]`, its standard error, `P(|q| > 0.5)`.
    pub rows: Vec<[f64; 6]>,
}

impl OscillatorEnsemble {
    /// Reads the file.
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/reference/derived/sde/oscillator_ensemble.json");
        Ok(serde_json::from_str(text)?)
    }
}

/// What diffrax took and how far off it was: the recorded output of `benches/rivals/diffrax_sde.py`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Diffrax {
    /// When it ran.
    pub date: String,
    /// Package by package.
    pub versions: std::collections::BTreeMap<String, String>,
    /// What it ran on.
    pub machine: DiffraxMachine,
    /// Paths behind an error.
    pub paths: u64,
    /// Paths of one call that was timed.
    pub timed_paths: u64,
    /// Its runs.
    pub rows: Vec<DiffraxRow>,
}

/// What the script ran on.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DiffraxMachine {
    /// The processor.
    pub processor: String,
    /// Threads used.
    pub threads: u64,
    /// Processes that wanted to run, mean of the last minute.
    pub load: f64,
}

/// One step length of one method.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DiffraxRow {
    /// `sine` or `damper`.
    pub problem: String,
    /// `euler`, `heun`, `shark`.
    pub method: String,
    /// Steps of a path.
    pub steps: u64,
    /// Median of five.
    pub cpu_seconds_per_path: f64,
    /// Half their range.
    pub cpu_seconds_scatter: f64,
    /// Root mean square distance to the reference at the end; none where a path left the numbers.
    pub strong_error: Option<f64>,
    /// Its standard error.
    pub strong_error_se: Option<f64>,
}

impl Diffrax {
    /// Reads the file.
    pub fn read() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/reference/derived/sde/diffrax.json");
        Ok(serde_json::from_str(text)?)
    }
}
