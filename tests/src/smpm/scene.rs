//! A scene of bodies on a grid as it stands in its JSON file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use smpm::material::Units;
use smpm::{Quantity, Window};

use super::material_scene::MaterialScene;

/// Bodies, their materials, what is random, and what is looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmpmScene {
    /// Always `smpm`.
    pub solver: String,
    /// One line for the reader.
    pub title: String,
    /// In which units all numbers are.
    pub units: UnitsScene,
    /// 1 (uniaxial strain), 2 (plane strain, or axisymmetric) or 3.
    pub dimension: usize,
    /// Two dimensions only: the first axis is the radius.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub axisymmetric: bool,
    /// The background grid and its particles.
    pub grid: GridScene,
    /// How a step is done.
    #[serde(default)]
    pub scheme: SchemeScene,
    /// Planes at which the motion is prescribed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boundaries: Vec<BoundaryScene>,
    /// What bodies that meet do to each other.
    #[serde(default, skip_serializing_if = "ContactScene::is_bonded")]
    pub contact: ContactScene,
    /// Acceleration of all particles along each axis (length per time squared); none where it is not given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gravity: Vec<f64>,
    /// Materials by name.
    pub materials: BTreeMap<String, MaterialScene>,
    /// The bodies.
    pub bodies: Vec<BodyScene>,
    /// Random parameters, eight at most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub random: Vec<RandomScene>,
    /// Correlations between them; zero where none is given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<CorrelationScene>,
    /// How mean and variance are found.
    pub method: MethodScene,
    /// Where it is looked at.
    pub gauges: Vec<GaugeScene>,
    /// What is looked at: `pressure`, `flow_stress`, `deviator_11`, and others.
    pub quantities: Vec<String>,
    /// When: instants, or `[from, to]` for the mean over a span.
    pub times: Vec<TimeScene>,
    /// Levels whose exceedance is asked for, by quantity.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub levels: BTreeMap<String, Vec<f64>>,
    /// Whether fields are written for ParaView at every time: mean and, with `propagated`, standard deviation.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fields: bool,
}

/// Systems of units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UnitsScene {
    /// Metre, kilogram, second.
    Si,
    /// Centimetre, gram, microsecond; stress in megabar.
    CmGUs,
    /// Millimetre, milligram, microsecond; stress in gigapascal.
    MmMgUs,
}

impl UnitsScene {
    /// The units.
    #[must_use]
    pub const fn units(self) -> Units {
        match self {
            Self::Si => Units::SI,
            Self::CmGUs => Units::CM_G_US,
            Self::MmMgUs => Units::MM_MG_US,
        }
    }

    /// Names of length, time, stress, density and velocity.
    #[must_use]
    pub const fn names(self) -> [&'static str; 5] {
        match self {
            Self::Si => ["m", "s", "Pa", "kg/m^3", "m/s"],
            Self::CmGUs => ["cm", "us", "Mbar", "g/cm^3", "cm/us"],
            Self::MmMgUs => ["mm", "us", "GPa", "mg/mm^3", "mm/us"],
        }
    }

    /// The unit of a quantity; empty for a pure number.
    #[must_use]
    pub const fn of(self, quantity: Quantity) -> &'static str {
        let [length, _, stress, density, velocity] = self.names();
        match quantity {
            Quantity::PlasticStrain | Quantity::Damage => "",
            Quantity::Temperature => "K",
            Quantity::Density => density,
            Quantity::Position(_) => length,
            Quantity::Velocity(_) => velocity,
            _ => stress,
        }
    }
}

/// The background grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridScene {
    /// The edge of a cell (length).
    pub cell: f64,
    /// Particles along the edge of a cell.
    pub particles_per_cell: u32,
}

/// How a step is done; what is not given is as in `Config::with_cell`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SchemeScene {
    /// Shape function.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<ShapeScene>,
    /// When the stress is updated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub update_order: Option<OrderScene>,
    /// How velocities come back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferScene>,
    /// Coefficients of the bulk viscosity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<ViscosityScene>,
    /// The Courant number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub courant_number: Option<f64>,
}

/// Coefficients of the bulk viscosity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViscosityScene {
    /// Of the square of the rate.
    pub quadratic: f64,
    /// Of the rate.
    pub linear: f64,
}

/// Shape functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeScene {
    /// Linear, the paper's.
    Linear,
    /// Generalised interpolation.
    Gimp,
    /// Quadratic B-splines.
    QuadraticBSpline,
    /// Cubic B-splines.
    CubicBSpline,
}

/// Update orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderScene {
    /// USF.
    StressFirst,
    /// USL.
    StressLast,
    /// MUSL.
    ModifiedStressLast,
}

/// Transfers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TransferScene {
    /// Affine.
    Apic,
    /// The change of velocity.
    Flip {
        /// The time over which it goes over to the velocity itself (time); never where it is not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        damping_time: Option<f64>,
    },
}

/// What bodies that meet do to each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ContactScene {
    /// They share one velocity and stick, as the paper's do.
    #[default]
    Bonded,
    /// They slide and part. The normal is that of the body that is given first: the flatter or stiffer one.
    Friction {
        /// Coulomb's coefficient.
        coefficient: f64,
    },
}

impl ContactScene {
    fn is_bonded(&self) -> bool {
        *self == Self::Bonded
    }
}

/// A plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoundaryScene {
    /// The axis it is normal to, from 1.
    pub axis: usize,
    /// Its coordinate (length).
    pub position: f64,
    /// Where the bodies are.
    pub side: SideScene,
    /// What it does.
    pub kind: BoundaryKindScene,
}

/// Sides of a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SideScene {
    /// At larger coordinates.
    Above,
    /// At smaller ones.
    Below,
}

/// What a plane does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BoundaryKindScene {
    /// Mirrors.
    Symmetry,
    /// Holds.
    Clamped,
    /// A wall without friction.
    Rigid,
    /// Lets waves out.
    Absorbing {
        /// Speed of longitudinal waves.
        longitudinal: f64,
        /// Speed of shear waves.
        shear: f64,
    },
}

/// A body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyScene {
    /// Its name, for gauges.
    pub name: String,
    /// The name of its material.
    pub material: String,
    /// What it fills.
    pub shape: SolidScene,
    /// What is cut out of that.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub except: Vec<SolidScene>,
    /// Its velocity; at rest where none is given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
}

/// A region of space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SolidScene {
    /// A box.
    Box {
        /// The lowest corner.
        from: Vec<f64>,
        /// The highest corner.
        to: Vec<f64>,
    },
    /// A ball; a disk in two dimensions.
    Ball {
        /// Its centre.
        centre: Vec<f64>,
        /// Its radius.
        radius: f64,
    },
    /// A circular cylinder in three dimensions along the third axis.
    Cylinder {
        /// The centre of its lower end.
        base: Vec<f64>,
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
}

/// A random parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomScene {
    /// `material.part.name`, e.g. `steel.strength.a`; its mean is the number in the scene.
    pub parameter: String,
    /// Its law.
    pub law: LawScene,
    /// Standard deviation over the mean.
    pub coefficient_of_variation: f64,
}

/// Laws of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LawScene {
    /// Normal; refused where it would leave the range too often.
    Normal,
    /// Lognormal.
    Lognormal,
}

/// A correlation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrelationScene {
    /// Two of the random parameters.
    pub between: [String; 2],
    /// From -1 to 1.
    pub value: f64,
}

/// How mean and variance are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MethodScene {
    /// One run at the centre of the parameters, no variance.
    Deterministic,
    /// The paper's derivatives at the local state: a baseline.
    Frozen {
        /// As printed, errors included.
        #[serde(default)]
        as_printed: bool,
    },
    /// Derivatives carried through the run.
    Propagated,
    /// Central differences of whole runs.
    FiniteDifference {
        /// How far, in standard deviations.
        step: f64,
    },
    /// `2N + 1` runs, three deviations wide.
    SigmaPoints,
    /// Whole runs at sampled parameters.
    MonteCarlo {
        /// How many.
        samples: u64,
        /// Everything that is drawn follows from it.
        seed: u64,
        /// With the surrogate of one run with derivatives as control variate.
        control: bool,
    },
}

/// A gauge; it goes with the material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeScene {
    /// Its name.
    pub name: String,
    /// The name of its body.
    pub body: String,
    /// The point whose nearest particles are averaged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Vec<f64>>,
    /// Or the box, from its lowest to its highest corner, whose particles are averaged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<[Vec<f64>; 2]>,
}

/// When.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TimeScene {
    /// An instant.
    At(f64),
    /// The mean over a span.
    Mean([f64; 2]),
}

impl TimeScene {
    /// As a window.
    #[must_use]
    pub const fn window(self) -> Window {
        match self {
            Self::At(time) => Window::at(time),
            Self::Mean([from, to]) => Window { from, to },
        }
    }
}
