//! The body of a crack scene: extent, material and bonds.

use peridyn_sde::{
    Condition, Error, Horizon, Influence, Strain, SurfaceCorrection, VolumeCorrection,
};
use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::named::named;
use super::positive::positive;

/// A rectangle with a corner at the origin, or points inside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyScene {
    /// Width and height, multiples of the spacing (m).
    pub size: [f64; 2],
    /// Distance of neighbouring nodes (m).
    pub spacing: f64,
    /// Plane stress or plane strain.
    pub condition: ConditionScene,
    /// A file of points, `.csv` or `.vtu`, relative to the folder of the scene; a lattice without this key.
    ///
    /// Its columns are `x` and `y` (m) and optionally `volume` (m^3), `strength_factor` and `stiffness_factor`. The
    /// spacing is then the mean one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = "points.csv")]
    pub points: Option<String>,
    /// Holes in the lattice; none without this key. Bonds across a hole narrower than the horizon remain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<HoleScene>,
}

/// A hole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::BOX)]
pub enum HoleScene {
    /// A circular hole.
    Circle {
        /// Its centre (m).
        centre: [f64; 2],
        /// Its radius (m).
        radius: f64,
    },
    /// A rectangular hole with edges along the axes.
    Box {
        /// The lower left corner (m).
        low: [f64; 2],
        /// The upper right corner (m).
        high: [f64; 2],
    },
}

impl HoleScene {
    const BOX: Self = Self::Box { low: [0.03, 0.01], high: [0.04, 0.02] };

    /// Whether a point (m) lies in it.
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
    /// Rejects an extent that is no integer number of spacings.
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

/// Plane condition.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::PlaneStrain { thickness: 1.0 })]
pub enum ConditionScene {
    /// Plane stress: a plate, free to contract in thickness.
    PlaneStress {
        /// Thickness of the body (m).
        thickness: f64,
    },
    /// Plane strain: a slice of a long body.
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

/// Material constants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialScene {
    /// Young's modulus (Pa). Without the key `law` bonds fix Poisson's ratio: 1/3 in plane stress, 1/4 in plane strain.
    pub young_modulus: f64,
    /// Constitutive law.
    #[serde(default, skip_serializing_if = "LawScene::is_bond_based")]
    #[schemars(extend("default" = LawScene::default()))]
    pub law: LawScene,
    /// Mass per volume (kg/m^3), required by inertial dynamics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Fracture criterion.
    pub toughness: ToughnessScene,
}

/// Constitutive law.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LawScene {
    /// Bonds of a pair potential.
    #[default]
    BondBased,
    /// Linear peridynamic solid (ordinary state-based), whose stiffness is uniform.
    LinearSolid {
        /// Poisson's ratio, greater than -1 and less than 0.5 (no unit).
        poisson_ratio: f64,
    },
}

impl LawScene {
    /// Whether it is the default.
    #[must_use]
    pub const fn is_bond_based(&self) -> bool {
        matches!(self, Self::BondBased)
    }
}

/// Fracture criterion of bonds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::CriticalStretch(1.5e-4))]
pub enum ToughnessScene {
    /// `G0`, the energy release rate; with the horizon it gives the critical stretch (J/m^2).
    EnergyReleaseRate(f64),
    /// `s0`, the critical stretch at which a bond breaks (no unit).
    CriticalStretch(f64),
    /// Bonds that soften, as of concrete: elastic up to the stretch `f_t/E`, from where their tension falls on a line to zero.
    ///
    /// Under a quasi-static load alone.
    Softening {
        /// `f_t`, the tensile strength (Pa).
        tensile_strength: f64,
        /// `G_f`, the energy that a crack takes; with the horizon it determines where the line ends (J/m^2).
        fracture_energy: f64,
    },
}

/// Bonds between nodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondsScene {
    /// Interaction radius of a node.
    pub horizon: HorizonScene,
    /// Influence function: weight of a bond by its length.
    #[serde(default)]
    #[schemars(example = InfluenceScene::Conical)]
    pub influence: InfluenceScene,
    /// Correction of volumes cut by the horizon.
    #[serde(default)]
    pub volume_correction: VolumeScene,
    /// Correction of bonds near the surface.
    #[serde(default)]
    #[schemars(example = SurfaceScene::Energy)]
    pub surface_correction: SurfaceScene,
    /// Strain measure of a bond.
    #[serde(default)]
    #[schemars(example = StrainKindScene::Linear)]
    pub strain: StrainKindScene,
}

/// The horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Length(0.0031))]
pub enum HorizonScene {
    /// Number of shells of neighbours, a little more than whole spacings: `(m + 0.015) dx` (no unit).
    Shells(u32),
    /// Length of the horizon (m).
    Length(f64),
}

impl HorizonScene {
    /// The horizon for a spacing.
    ///
    /// # Errors
    /// An [`Objection`] to one below the spacing, or that passes through nodes.
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
    /// Volume correction.
    VolumeScene => VolumeCorrection {
        /// No correction.
        #[default]
        None,
        /// Within the last half spacing inside the horizon, as in LAMMPS.
        Partial,
        /// Within half a spacing on both sides of the horizon.
        Ramp,
    }
}

named! {
    /// Surface correction.
    SurfaceScene => SurfaceCorrection {
        /// No correction.
        #[default]
        None,
        /// From the strain energy under a strain along each axis.
        Energy,
    }
}

named! {
    /// Strain measure.
    StrainKindScene => Strain {
        /// Of the bond in its current configuration.
        #[default]
        Finite,
        /// Linear in the displacements.
        Linear,
    }
}
