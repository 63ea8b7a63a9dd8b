//! The body of a scene of cracks: its extent, what it is made of and how it is bonded.

use peridyn_sde::{
    Condition, Error, Horizon, Influence, Strain, SurfaceCorrection, VolumeCorrection,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::named::named;
use super::positive::positive;
use crate::scene::Objection;

/// A rectangle, from the origin, or points inside of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyScene {
    /// Width and height, multiples of the spacing (m).
    pub size: [f64; 2],
    /// Distance of neighbouring nodes (m).
    pub spacing: f64,
    /// What the plane stands for.
    pub condition: ConditionScene,
    /// A file of points, from the folder of the scene: `.csv` or `.vtu`, with the columns `x` and `y` (m) and, if they are wanted,
    /// `volume` (m^3), `strength_factor` and `stiffness_factor`. The spacing is then the mean one. Without it a lattice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = "points.csv")]
    pub points: Option<String>,
    /// What is taken out of the lattice; without it nothing. Bonds across a hole that is narrower than the horizon remain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<HoleScene>,
}

/// Holes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::BOX)]
pub enum HoleScene {
    /// Round.
    Circle {
        /// Its centre (m).
        centre: [f64; 2],
        /// Its radius (m).
        radius: f64,
    },
    /// With edges along the axes.
    Box {
        /// The lower left corner (m).
        low: [f64; 2],
        /// The upper right corner (m).
        high: [f64; 2],
    },
}

impl HoleScene {
    const BOX: Self = Self::Box { low: [0.03, 0.01], high: [0.04, 0.02] };

    /// Whether a place (m) lies in it.
    #[must_use]
    pub fn contains(&self, x: &[f64; 2]) -> bool {
        match *self {
            Self::Circle { centre, radius } => (x[0] - centre[0]).hypot(x[1] - centre[1]) < radius,
            Self::Box { low, high } => (0..2).all(|k| x[k] > low[k] && x[k] < high[k]),
        }
    }

    fn check(&self, path: &str) -> Result<(), Objection> {
        match *self {
            Self::Circle { radius, .. } => {
                positive(&format!("{path}.circle.radius"), "the radius", radius)
            }
            Self::Box { low, high } => match (0..2).find(|&k| low[k] >= high[k]) {
                Some(k) => {
                    let message = format!("the box goes from {} m to {} m", low[k], high[k]);
                    Err(Objection::new(format!("{path}.box.high[{k}]"), message))
                }
                None => Ok(()),
            },
        }
    }
}

impl BodyScene {
    /// Refuses an extent that is no whole number of spacings.
    ///
    /// # Errors
    /// An [`Objection`] to the spacing or a length.
    pub fn check(&self) -> Result<(), Objection> {
        positive("body.spacing", "the spacing", self.spacing)?;
        self.check_size(0, "width")?;
        self.check_size(1, "height")?;
        for (i, hole) in self.holes.iter().enumerate() {
            hole.check(&format!("body.holes[{i}]"))?;
        }
        if self.points.is_some() && !self.holes.is_empty() {
            let message = "holes are taken out of a lattice, and the body is one of points";
            return Err(
                Objection::new("body.holes", message).with_help("leave them out of the file")
            );
        }
        Ok(())
    }

    fn check_size(&self, k: usize, name: &str) -> Result<(), Objection> {
        let (path, value) = (format!("body.size[{k}]"), self.size[k]);
        positive(&path, &format!("the {name}"), value)?;
        let boxes = value / self.spacing;
        if boxes < 1.5 || (boxes - boxes.round()).abs() > 1e-6 * boxes {
            let spacing = self.spacing;
            let message = format!("the {name} is {value} m, {boxes} spacings of {spacing} m");
            let help = "it must be a whole number of spacings, two or more";
            return Err(Objection::new(path, message).with_help(help));
        }
        Ok(())
    }
}

/// Plane conditions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::PlaneStrain { thickness: 1.0 })]
pub enum ConditionScene {
    /// A plate, free to contract across.
    PlaneStress {
        /// Thickness of the body (m).
        thickness: f64,
    },
    /// A slice of a long body.
    PlaneStrain {
        /// Thickness of the body (m).
        thickness: f64,
    },
}

impl From<ConditionScene> for Condition {
    fn from(scene: ConditionScene) -> Self {
        match scene {
            ConditionScene::PlaneStress { thickness } => Self::PlaneStress { thickness },
            ConditionScene::PlaneStrain { thickness } => Self::PlaneStrain { thickness },
        }
    }
}

/// Constants of a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialScene {
    /// Young's modulus (Pa). Bonds fix Poisson's ratio: 1/3 in plane stress, 1/4 in plane strain.
    pub young_modulus: f64,
    /// Mass per volume (kg/m^3); inertial dynamics need it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// When it breaks.
    pub toughness: ToughnessScene,
}

/// When bonds break.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::CriticalStretch(1.5e-4))]
pub enum ToughnessScene {
    /// `G0`, from which with the horizon the critical stretch follows (J/m^2).
    EnergyReleaseRate(f64),
    /// `s0`, the stretch at which a bond breaks (no unit).
    CriticalStretch(f64),
}

/// How nodes are bonded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondsScene {
    /// How far a node sees.
    pub horizon: HorizonScene,
    /// Weight of a bond by its length.
    #[serde(default)]
    #[schemars(example = InfluenceScene::Conical)]
    pub influence: InfluenceScene,
    /// Correction of volumes that the horizon cuts.
    #[serde(default)]
    pub volume_correction: VolumeScene,
    /// Correction of bonds near the surface.
    #[serde(default)]
    #[schemars(example = SurfaceScene::Energy)]
    pub surface_correction: SurfaceScene,
    /// How the strain of a bond is measured.
    #[serde(default)]
    #[schemars(example = StrainKindScene::Linear)]
    pub strain: StrainKindScene,
}

/// Horizons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Length(0.0031))]
pub enum HorizonScene {
    /// So many whole spacings and a little more: `(m + 0.015) dx` (no unit).
    Shells(u32),
    /// The length itself (m).
    Length(f64),
}

impl HorizonScene {
    /// The horizon of nodes at a spacing.
    ///
    /// # Errors
    /// An [`Objection`] to one below the spacing, or that ends on nodes.
    pub fn of(self, spacing: f64) -> Result<Horizon, Objection> {
        let (key, horizon) = match self {
            Self::Shells(shells) => ("shells", Horizon::of_shells(shells, spacing)),
            Self::Length(length) => ("length", Horizon::new(length, spacing)),
        };
        horizon.map_err(|error| {
            let objection = Objection::new(format!("bonds.horizon.{key}"), error.to_string());
            match error {
                Error::HorizonTooShort { .. } => {
                    objection.with_help("three to four shells are usual: { \"shells\": 3 }")
                }
                _ => objection,
            }
        })
    }
}

named! {
    /// Influence functions of `q`, the length of a bond over the horizon.
    InfluenceScene => Influence {
        /// `1`.
        #[default]
        Constant,
        /// `1 - q`.
        Conical,
        /// `(1 - q^2)^2`.
        Quartic,
    }
}

named! {
    /// Volume corrections.
    VolumeScene => VolumeCorrection {
        /// Nothing.
        #[default]
        None,
        /// Of the last half spacing inside the horizon, as in LAMMPS.
        Partial,
        /// Of half a spacing on both sides of it.
        Ramp,
    }
}

named! {
    /// Surface corrections.
    SurfaceScene => SurfaceCorrection {
        /// Nothing.
        #[default]
        None,
        /// By the energy under a strain along each axis.
        Energy,
    }
}

named! {
    /// How strains are measured.
    StrainKindScene => Strain {
        /// Of the bond as it stands.
        #[default]
        Finite,
        /// Linear in displacements.
        Linear,
    }
}
