//! What holds and what moves the body of a crack scene.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::scene_body::BodyScene;

/// Rows of nodes at the lower and the upper edge with prescribed displacement.
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

/// The prescribed motion: of the edges along the vertical, or of the nodes of a region.
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
    /// The nodes of a region are displaced while `supports` hold the body.
    Displacement {
        /// Where they are.
        region: RegionScene,
        /// Displacement at the end of the run (m). A component of 0 is not prescribed: a support may hold it.
        ///
        /// The load is the force along the larger component.
        until: [f64; 2],
        /// Distance from the region within which no bond breaks (m).
        #[serde(default)]
        #[schemars(example = 0.006)]
        protected: f64,
    },
}

/// Nodes that are held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SupportScene {
    /// Where they are.
    pub region: RegionScene,
    /// Directions in which they are held.
    pub hold: DirectionScene,
    /// Distance from the region within which no bond breaks (m).
    #[serde(default)]
    #[schemars(example = 0.01)]
    pub protected: f64,
}

/// Directions in which nodes are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DirectionScene {
    /// Both.
    Both,
    /// Along x alone.
    X,
    /// Along y alone.
    Y,
}

impl DirectionScene {
    /// The prescribed components.
    #[must_use]
    pub const fn directions(self) -> [bool; 2] {
        match self {
            Self::Both => [true, true],
            Self::X => [true, false],
            Self::Y => [false, true],
        }
    }
}

/// A rectangle with edges along the axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionScene {
    /// The lower left corner (m).
    pub low: [f64; 2],
    /// The upper right corner (m).
    pub high: [f64; 2],
}

impl RegionScene {
    /// The distance of a point from it (m); 0 inside.
    #[must_use]
    pub fn distance(&self, x: &[f64; 2]) -> f64 {
        let off: [f64; 2] =
            std::array::from_fn(|k| (self.low[k] - x[k]).max(x[k] - self.high[k]).max(0.0));
        off[0].hypot(off[1])
    }

    /// Rejects corners in the wrong order and a negative distance around it, both under a path.
    pub(crate) fn check(&self, path: &str, protected: f64) -> Result<(), Objection> {
        if let Some(k) = (0..2).find(|&k| self.low[k] > self.high[k]) {
            let message = format!("the region goes from {} m to {} m", self.low[k], self.high[k]);
            return Err(Objection::new(format!("{path}.region.high[{k}]"), message));
        }
        if protected.is_finite() && protected >= 0.0 {
            return Ok(());
        }
        let message = format!("bonds are protected within {protected} m of the region");
        Err(Objection::new(format!("{path}.protected"), message).with_help("0 or more"))
    }
}

impl GripsScene {
    pub(crate) fn check(&self, body: &BodyScene) -> Result<(), Objection> {
        let (height, spacing, whole) = (self.height, body.spacing, body.size[1]);
        if !(height >= spacing && height < 0.5 * whole) {
            let message = format!("the height of the edge regions is {height} m");
            let help =
                format!("between one spacing, {spacing} m, and half of the body's {whole} m");
            return Err(Objection::new("grips.height", message).with_help(help));
        }
        let protected = self.protected;
        if !(protected >= 0.0 && protected < 0.5 * whole) {
            let message = format!("bonds are protected within {protected} m of an edge");
            let help = format!("between 0 and half of the body's {whole} m");
            return Err(Objection::new("grips.protected", message).with_help(help));
        }
        Ok(())
    }
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
