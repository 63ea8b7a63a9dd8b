//! A crack scene as written in its JSON file: an ensemble of tension tests on a notched plate, in SI units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::positive::positive;
use super::scene_body::{BodyScene, BondsScene, MaterialScene};
use super::scene_dynamics::{DynamicsScene, TimeScene};
use super::scene_field::VariationScene;
use crate::scene::{Objection, Scene, WrongKey, read_keys};

/// An ensemble of tension tests on a notched plate: body, bonds, loading, dynamics, random inputs and output.
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
    /// Regions with prescribed displacement.
    pub grips: GripsScene,
    /// Prescribed motion.
    pub loading: LoadingScene,
    /// Dynamics of the nodes.
    pub dynamics: DynamicsScene,
    /// Step length and number of steps.
    pub time: TimeScene,
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
    /// Its mouth, on the left or right edge (m).
    pub mouth: [f64; 2],
    /// Its tip, where cracks start, inside the body (m).
    pub tip: [f64; 2],
}

/// Regions with prescribed displacement: rows of nodes at the lower and the upper edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GripsScene {
    /// Height of each region (m).
    pub height: f64,
    /// Directions in which the displacement is prescribed.
    #[serde(default)]
    pub hold: HoldScene,
    /// Distance from the lower and upper edge within which no bond breaks (m).
    #[serde(default)]
    #[schemars(example = 0.006)]
    pub protected: f64,
}

/// Directions of a prescribed displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HoldScene {
    /// Both directions.
    #[default]
    Clamped,
    /// The direction of the load alone.
    Sliding,
}

impl HoldScene {
    /// The prescribed components.
    #[must_use]
    pub const fn directions(self) -> [bool; 2] {
        match self {
            Self::Clamped => [true, true],
            Self::Sliding => [false, true],
        }
    }
}

/// The prescribed motion along the vertical.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Velocity { speed: 0.5 })]
pub enum LoadingScene {
    /// The mean strain increases linearly with time; free nodes move with it, and relaxation adds the difference.
    Stretch {
        /// Mean strain at the end of the run.
        strain: StrainScene,
    },
    /// The edge regions move apart; free nodes have no prescribed motion.
    Velocity {
        /// Speed of each edge region (m/s).
        speed: f64,
    },
}

/// A mean strain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Value(2e-4))]
pub enum StrainScene {
    /// The strain itself (no unit).
    Value(f64),
    /// Ratio to the critical stretch (no unit).
    OverCriticalStretch(f64),
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

impl Scene for CrackScene {
    type Built = ();

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<(), Objection> {
        self.body.check()?;
        positive("material.young_modulus", "Young's modulus", self.material.young_modulus)?;
        self.check_count()?;
        self.check_notch()?;
        self.check_grips()?;
        self.check_output()
    }

    fn seed(&mut self) -> Option<&mut u64> {
        Some(&mut self.ensemble.seed)
    }
}

/// Most nodes of a body.
const MOST_NODES: f64 = 4e6;
/// Bytes of a bond in a list: two nodes, length, factors, state.
const BYTES_OF_A_BOND: f64 = 64.0;

impl CrackScene {
    /// Rejects more nodes than a run holds, with the memory that their bonds would take.
    fn check_count(&self) -> Result<(), Objection> {
        let (body, spacing) = (&self.body, self.body.spacing);
        let nodes = body.size[0] / spacing * (body.size[1] / spacing);
        if nodes <= MOST_NODES {
            return Ok(());
        }
        let reach = self.bonds.horizon.of(spacing)?.radius() / spacing;
        let bonds = 0.5 * std::f64::consts::PI * reach * reach * nodes;
        let message = format!(
            "the body has {nodes:.3e} nodes, whose {bonds:.3e} bonds take about {:.0} GB for each realisation at work; at most {MOST_NODES:e} are allowed",
            bonds * BYTES_OF_A_BOND * 1e-9
        );
        let help = "choose a larger spacing, or a smaller part of the body around the notch";
        Err(Objection::new("body.spacing", message).with_help(help))
    }

    /// Rejects a notch that does not come from an edge, or whose tip a hole removes.
    fn check_notch(&self) -> Result<(), Objection> {
        let NotchScene { mouth, tip } = self.notch;
        let (width, spacing) = (self.body.size[0], self.body.spacing);
        if mouth[0].min(width - mouth[0]).abs() > 0.5 * spacing {
            let message =
                format!("the mouth of the notch is at x = {} m, inside the body", mouth[0]);
            let help = format!(
                "it must be on an edge, at x = 0 or {width} m: the body is not cut from inside"
            );
            return Err(Objection::new("notch.mouth[0]", message).with_help(help));
        }
        let hole = self.body.holes.iter().position(|hole| hole.contains(&tip));
        let Some(hole) = hole else { return Ok(()) };
        let message =
            format!("the tip of the notch lies in hole {hole}, so that no crack starts there");
        let help = "end the notch before the hole, or leave out one of the two";
        Err(Objection::new("notch.tip", message).with_help(help))
    }

    fn check_grips(&self) -> Result<(), Objection> {
        let (height, spacing, whole) = (self.grips.height, self.body.spacing, self.body.size[1]);
        if !(height >= spacing && height < 0.5 * whole) {
            let message = format!("the height of the edge regions is {height} m");
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
