//! A crack scene as written in its JSON file: an ensemble of tests on a notched body, in SI units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::scene_body::{BodyScene, BondsScene, MaterialScene};
use super::scene_dynamics::{DynamicsScene, TimeScene};
use super::scene_field::VariationScene;
use super::scene_load::{GripsScene, LoadingScene, SupportScene};

/// An ensemble of tests on a notched body: body, bonds, loading, dynamics, random inputs and output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackScene {
    /// Always `peridyn-sde`.
    pub solver: String,
    /// Title, one line.
    pub title: String,
    /// The plate.
    pub body: BodyScene,
    /// Elastic constants and toughness.
    pub material: MaterialScene,
    /// Bonds between nodes.
    pub bonds: BondsScene,
    /// The notch, where cracks start.
    pub notch: NotchScene,
    /// Rows of nodes at the lower and the upper edge with prescribed displacement; or `supports` in their place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grips: Option<GripsScene>,
    /// Nodes that are held, for a load by `displacement`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<SupportScene>,
    /// Prescribed motion.
    pub loading: LoadingScene,
    /// Dynamics of the nodes.
    pub dynamics: DynamicsScene,
    /// Step length and number of steps, required by dynamics in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<TimeScene>,
    /// Spatial variation of the critical stretch.
    #[schemars(example = VariationScene::BY_VOLUME)]
    pub strength: VariationScene,
    /// Spatial variation of the bond stiffness.
    #[serde(default, skip_serializing_if = "VariationScene::is_uniform")]
    #[schemars(extend("default" = VariationScene::default()), example = VariationScene::COLUMN)]
    pub stiffness: VariationScene,
    /// Number and precision of the realisations.
    pub ensemble: EnsembleScene,
    /// Output.
    #[serde(default)]
    pub output: OutputScene,
}

/// A notch: a straight cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NotchScene {
    /// Its mouth, on an edge or in a hole (m).
    pub mouth: [f64; 2],
    /// Its tip, where cracks start, inside the body (m).
    pub tip: [f64; 2],
}

/// Number and precision of the realisations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnsembleScene {
    /// Number of realisations (no unit).
    pub realisations: u64,
    /// Seed of all random numbers (no unit).
    pub seed: u64,
    /// Floating-point precision of a step.
    pub precision: PrecisionScene,
}

/// Floating-point precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PrecisionScene {
    /// Double: eight realisations side by side.
    F64,
    /// Single: sixteen realisations side by side.
    F32,
}

impl PrecisionScene {
    /// Realisations side by side.
    #[must_use]
    pub const fn n_lanes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::F32 => 16,
        }
    }
}

/// Output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OutputScene {
    /// Numbers of realisations, from 0, whose final state is written for ParaView (no unit).
    pub vtu: Vec<u64>,
    /// Abscissae at which the path is recorded (m); default: every fourth spacing from the tip of the notch.
    #[schemars(example = vec![0.024, 0.032, 0.048])]
    pub abscissae: Vec<f64>,
    /// Number of windows of equal length over which the load is averaged (no unit).
    ///
    /// Under a quasi-static load it is observed at the end of each.
    pub windows: u64,
    /// Damage above which a node counts as damaged in the map, between 0 and 1 (no unit).
    #[schemars(example = 0.4)]
    pub damage_threshold: f64,
}

impl Default for OutputScene {
    fn default() -> Self {
        Self { vtu: Vec::new(), abscissae: Vec::new(), windows: 50, damage_threshold: 0.3 }
    }
}

/// Parts of a quasi-static load by which the failure of bonds is recorded.
const PARTS: u64 = 1000;

impl CrackScene {
    /// Whether the load grows slowly, from equilibrium to equilibrium.
    #[must_use]
    pub const fn is_quasi_static(&self) -> bool {
        matches!(self.dynamics, DynamicsScene::QuasiStatic { .. })
    }

    /// Steps of a realisation; under a quasi-static load, parts of it.
    #[must_use]
    pub fn n_steps(&self) -> u64 {
        self.time.as_ref().map_or(PARTS, |time| time.steps)
    }

    /// Realisations that run side by side.
    #[must_use]
    pub const fn n_side_by_side(&self) -> u64 {
        if self.is_quasi_static() { 1 } else { self.ensemble.precision.n_lanes() }
    }
}
