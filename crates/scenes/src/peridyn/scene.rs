//! A scene of cracks as it stands in its JSON file: a notched plate that is pulled apart, again and again. All numbers are in SI
//! units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::positive::positive;
use super::scene_body::{BodyScene, BondsScene, MaterialScene};
use super::scene_dynamics::{DynamicsScene, TimeScene};
use super::scene_field::VariationScene;
use crate::scene::{Objection, Scene, WrongKey, read_keys};

/// A notched plate that is pulled apart, again and again: its bonds, what pulls it, how it moves, what is random, what is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackScene {
    /// Always `peridyn-sde`.
    pub solver: String,
    /// One line for the reader.
    pub title: String,
    /// The plate.
    pub body: BodyScene,
    /// What it is made of.
    pub material: MaterialScene,
    /// How its nodes are bonded.
    pub bonds: BondsScene,
    /// Where cracks begin.
    pub notch: NotchScene,
    /// What it is held by.
    pub grips: GripsScene,
    /// What they do.
    pub loading: LoadingScene,
    /// How nodes move.
    pub dynamics: DynamicsScene,
    /// By which steps, and how many.
    pub time: TimeScene,
    /// How the critical stretch varies from place to place.
    pub strength: VariationScene,
    /// How the stiffness of bonds varies from place to place.
    #[serde(default, skip_serializing_if = "VariationScene::is_uniform")]
    #[schemars(extend("default" = VariationScene::default()), example = VariationScene::COLUMN)]
    pub stiffness: VariationScene,
    /// How many realisations.
    pub ensemble: EnsembleScene,
    /// What is told of them.
    #[serde(default)]
    pub output: OutputScene,
}

/// A notch: a straight cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NotchScene {
    /// Where it begins, on the left or right edge (m).
    pub mouth: [f64; 2],
    /// Where cracks begin, inside the body (m).
    pub tip: [f64; 2],
}

/// What holds the plate: rows of nodes at the lower and the upper edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GripsScene {
    /// Height of each (m).
    pub height: f64,
    /// In which directions.
    #[serde(default)]
    pub hold: HoldScene,
    /// No bond breaks of a node within so much of the lower and upper edge (m).
    #[serde(default)]
    #[schemars(example = 0.006)]
    pub protected: f64,
}

/// How a grip holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HoldScene {
    /// In both directions.
    #[default]
    Clamped,
    /// In the direction of the load alone.
    Sliding,
}

impl HoldScene {
    /// Which components it gives.
    #[must_use]
    pub const fn directions(self) -> [bool; 2] {
        match self {
            Self::Clamped => [true, true],
            Self::Sliding => [false, true],
        }
    }
}

/// What the grips do, along the vertical.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Velocity { speed: 0.5 })]
pub enum LoadingScene {
    /// The body is stretched evenly with time; nodes between the grips are moved along, and relaxation makes the difference.
    Stretch {
        /// The mean strain at the end of the run.
        strain: StrainScene,
    },
    /// Each grip moves away from the other, and only grips feel it.
    Velocity {
        /// Speed of each grip (m/s).
        speed: f64,
    },
}

/// A mean strain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Value(2e-4))]
pub enum StrainScene {
    /// The number itself (no unit).
    Value(f64),
    /// Over the critical stretch (no unit).
    OverCriticalStretch(f64),
}

/// How many realisations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnsembleScene {
    /// How many (no unit).
    pub realisations: u64,
    /// All that is random follows from it (no unit).
    pub seed: u64,
    /// Precision of the numbers in a step.
    pub precision: PrecisionScene,
}

/// Precision.
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

/// What is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OutputScene {
    /// Numbers of realisations, from 0, whose end is written for ParaView (no unit).
    pub vtu: Vec<u64>,
    /// Where along the first axis the path is looked at (m); without any, from the tip of the notch on at every fourth spacing.
    #[schemars(example = vec![0.024, 0.032, 0.048])]
    pub abscissae: Vec<f64>,
    /// The load is averaged over so many windows of equal length (no unit).
    pub windows: u64,
    /// Damage from which a node counts as damaged in the map, between 0 and 1 (no unit).
    #[schemars(example = 0.4)]
    pub damage_threshold: f64,
}

impl Default for OutputScene {
    fn default() -> Self {
        Self { vtu: Vec::new(), abscissae: Vec::new(), windows: 50, damage_threshold: 0.3 }
    }
}

impl Scene for CrackScene {
    type Built = ();

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<(), Objection> {
        self.body.check()?;
        positive("material.young_modulus", "Young's modulus", self.material.young_modulus)?;
        self.check_grips()?;
        self.check_output()
    }

    fn seed(&mut self) -> Option<&mut u64> {
        Some(&mut self.ensemble.seed)
    }
}

impl CrackScene {
    fn check_grips(&self) -> Result<(), Objection> {
        let (height, spacing, whole) = (self.grips.height, self.body.spacing, self.body.size[1]);
        if !(height >= spacing && height < 0.5 * whole) {
            let message = format!("grips of the height {height} m");
            let help =
                format!("between one spacing, {spacing} m, and half of the body's {whole} m");
            return Err(Objection::new("grips.height", message).with_help(help));
        }
        let protected = self.grips.protected;
        if !(protected >= 0.0 && protected < 0.5 * whole) {
            let message = format!("bonds are protected within {protected} m of an edge");
            let help = format!("between 0 and half of the body's {whole} m");
            return Err(Objection::new("grips.protected", message).with_help(help));
        }
        Ok(())
    }

    fn check_output(&self) -> Result<(), Objection> {
        let n = self.ensemble.realisations;
        if n == 0 {
            let message = "0 realisations; at least 1 is needed";
            return Err(Objection::new("ensemble.realisations", message));
        }
        if let Some(i) = self.output.vtu.iter().position(|&id| id >= n) {
            let (id, last) = (self.output.vtu[i], n - 1);
            let message = format!("there is no realisation {id}: numbers go from 0 to {last}");
            return Err(Objection::new(format!("output.vtu[{i}]"), message));
        }
        let (windows, steps) = (self.output.windows, self.time.steps);
        if steps == 0 {
            return Err(Objection::new("time.steps", "0 steps; at least 1 is needed"));
        }
        if windows == 0 || windows > steps {
            let message = format!("{windows} windows of the load over {steps} steps");
            return Err(Objection::new("output.windows", message));
        }
        let threshold = self.output.damage_threshold;
        if !(threshold > 0.0 && threshold < 1.0) {
            let message =
                format!("the threshold of damage is {threshold}; it must lie between 0 and 1");
            return Err(Objection::new("output.damage_threshold", message));
        }
        let width = self.body.size[0];
        for (i, &x) in self.output.abscissae.iter().enumerate() {
            if !(x > 0.0 && x < width) {
                let message = format!("the abscissa {x} m lies outside the body, 0 to {width} m");
                return Err(Objection::new(format!("output.abscissae[{i}]"), message));
            }
        }
        Ok(())
    }
}
