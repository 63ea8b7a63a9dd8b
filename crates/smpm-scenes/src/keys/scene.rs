//! A scene of bodies on a grid as written in its JSON file.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::Window;
use smpm::uncertainty::Design;

use super::load_scene::LoadScene;
use super::material_scene::MaterialScene;
use super::method_scene::MethodScene;
use super::quantity_name::QuantityName;
use super::random_field_scene::RandomFieldScene;
use super::sweep_scene::SweepScene;
pub use super::units_scene::UnitsScene;
use crate::point_list::PointList;
use crate::surface::Surface;

/// Deformable bodies on a background grid: materials, random parameters, and observed quantities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SmpmScene {
    /// Always `smpm`.
    pub solver: String,
    /// Title, one line.
    pub title: String,
    /// System of units of all numbers in the scene.
    pub units: UnitsScene,
    /// 1 for uniaxial strain, 2 for plane strain or axisymmetric, or 3 (no unit).
    pub dimension: usize,
    /// Whether the first of two axes is the radius; false without this key. The radius 0 then is a plane of symmetry by itself.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub axisymmetric: bool,
    /// The background grid and its particles.
    pub grid: GridScene,
    /// Time step algorithm; omitted keys have default values.
    #[serde(default)]
    pub scheme: SchemeScene,
    /// Planes with prescribed motion; none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boundaries: Vec<BoundaryScene>,
    /// Interaction of bodies in contact.
    #[serde(default, skip_serializing_if = "ContactScene::is_bonded")]
    #[schemars(extend("default" = ContactScene::default()), example = ContactScene::Friction { coefficient: 0.3 })]
    pub contact: ContactScene,
    /// Acceleration of all particles along each axis (length/time^2 of `units`); none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![0.0, -9.81])]
    pub gravity: Vec<f64>,
    /// The multiple of `gravity` over time, as points of time (time of `units`) and multiple in ascending order; 1 without this key.
    ///
    /// It is linear between points, and constant before the first and after the last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![[0.0, 0.0], [2.0, 1.0]])]
    pub gravity_history: Vec<[f64; 2]>,
    /// Materials, each under a name of your choice.
    pub materials: BTreeMap<String, MaterialScene>,
    /// The bodies.
    pub bodies: Vec<BodyScene>,
    /// Random parameters, at most eight; none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub random: Vec<RandomScene>,
    /// Correlations between them; none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![CorrelationScene::between_steel_parameters()])]
    pub correlations: Vec<CorrelationScene>,
    /// Material constants that vary in space, instead of random parameters; none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![RandomFieldScene::of_yield_stress()])]
    pub random_fields: Vec<RandomFieldScene>,
    /// Method for mean and variance.
    pub method: MethodScene,
    /// A sweep over one number, which answers where an event begins or how probable it is; none without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = SweepScene::of_velocity())]
    pub sweep: Option<SweepScene>,
    /// Gauges, at least one.
    pub gauges: Vec<GaugeScene>,
    /// Observed quantities, at least one.
    #[schemars(with = "Vec<QuantityName>")]
    pub quantities: Vec<String>,
    /// Times of observation, at least one: instants, or `[from, to]` for the mean over a window.
    pub times: Vec<TimeScene>,
    /// Levels whose exceedance probability is computed, by quantity (unit of that quantity); none without this key.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub levels: BTreeMap<String, Vec<f64>>,
    /// Whether fields are written for ParaView at every time; false without this key.
    ///
    /// The fields are the mean and, with `propagated`, the standard deviation. With `random_fields` they are those of one realisation: the
    /// first sample of `monte_carlo`, else all factors at their medians; the constants that vary are written too.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fields: bool,
}

impl SmpmScene {
    /// The complete runs of its method, if it samples.
    pub(crate) fn design(&self) -> Option<Design> {
        self.method.design(self.random.len())
    }
}

/// The background grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridScene {
    /// Edge length of a cell (length of `units`).
    pub cell: f64,
    /// Particles along the edge of a cell (no unit). One is far too stiff for bodies that bend.
    #[serde(default = "two")]
    pub particles_per_cell: u32,
}

/// The usual number of particles along the edge of a cell.
const fn two() -> u32 {
    2
}

/// Time step algorithm.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SchemeScene {
    /// Shape function.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = ShapeScene::QuadraticBSpline))]
    pub shape: Option<ShapeScene>,
    /// Transfer of velocities from the grid to the particles (G2P).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = TransferScene::Flip {}))]
    pub transfer: Option<TransferScene>,
    /// Coefficients of the bulk viscosity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = ViscosityScene { quadratic: 1.5, linear: 0.06 }))]
    pub viscosity: Option<ViscosityScene>,
    /// The Courant number (no unit).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 0.4), example = 0.2)]
    pub courant_number: Option<f64>,
    /// Local damping, from 0 to 0.95 (no unit), for bodies that come to rest under a load: the share of the force on each node that acts
    /// against its velocity. The state at rest does not depend on it; free flight and impact would.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 0.0), example = 0.5)]
    pub damping: Option<f64>,
}

/// Coefficients of the bulk viscosity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscosityScene {
    /// Coefficient of the squared rate: spreads strong shocks over a few cells (no unit).
    pub quadratic: f64,
    /// Coefficient of the rate: damps post-shock oscillations (no unit).
    pub linear: f64,
}

/// Shape functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShapeScene {
    /// Quadratic B-splines.
    QuadraticBSpline,
    /// Cubic B-splines.
    CubicBSpline,
}

/// Grid-to-particle transfers (G2P).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Flip {})]
pub enum TransferScene {
    /// Velocity and its gradient (APIC): conserves angular momentum.
    Apic,
    /// Change of the velocity (FLIP): conserves energy.
    Flip {},
}

/// Interaction of bodies in contact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ContactScene {
    /// Bonded: bodies share one velocity field, as in the paper.
    #[default]
    Bonded,
    /// Frictional contact with separation. No impulse acts before the gap between the bodies has closed.
    Friction {
        /// Coulomb's friction coefficient (no unit).
        coefficient: f64,
    },
}

impl ContactScene {
    fn is_bonded(&self) -> bool {
        *self == Self::Bonded
    }
}

/// A plane with prescribed motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundaryScene {
    /// Axis of its normal, from 1 (no unit).
    pub axis: usize,
    /// Its coordinate (length of `units`).
    pub position: f64,
    /// Side of the plane on which the bodies are.
    pub side: SideScene,
    /// Boundary condition.
    pub kind: BoundaryKindScene,
}

/// Sides of a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SideScene {
    /// At larger coordinates.
    Above,
    /// At smaller ones.
    Below,
}

/// Boundary condition of a plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Absorbing { longitudinal: 0.6, shear: 0.32 }, example = Self::Frictional { friction: 0.3 })]
pub enum BoundaryKindScene {
    /// Symmetry plane.
    Symmetry,
    /// All velocity components are zero.
    Clamped,
    /// A rigid wall without friction.
    Rigid,
    /// A rigid wall with Coulomb friction.
    Frictional {
        /// Coulomb's friction coefficient (no unit).
        friction: f64,
    },
    /// A non-reflecting boundary.
    Absorbing {
        /// Speed of longitudinal waves (length/time of `units`).
        longitudinal: f64,
        /// Speed of shear waves (length/time of `units`).
        shear: f64,
    },
}

/// A body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyScene {
    /// Its name, for gauges.
    pub name: String,
    /// The name of its material.
    pub material: String,
    /// Region that it fills.
    pub shape: SolidScene,
    /// Region cut out of it; none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub except: Vec<SolidScene>,
    /// Rotation of its shape and of the regions cut out; none without this key.
    ///
    /// Particles stay on the lattice of the grid, so that the surface of a rotated body has steps. Its velocity is not rotated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = RotationScene { about: vec![0.0, 0.0], axis: vec![], degrees: 20.0 })]
    pub rotation: Option<RotationScene>,
    /// Its initial velocity along each axis (length/time of `units`); at rest without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
    /// Whether it is rigid and keeps its velocity whatever it meets, as a platen or a hard projectile does; false without this key.
    ///
    /// One body of a scene may be, with contact with friction. Neither gravity nor boundaries act on it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schemars(example = true)]
    pub rigid: bool,
    /// Loads on its surface; none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![LoadScene::on_top()])]
    pub loads: Vec<LoadScene>,
}

/// A rotation, in two dimensions with plane strain or in three.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationScene {
    /// A point that it leaves in place (length of `units`).
    #[schemars(example = vec![0.0, 0.0])]
    pub about: Vec<f64>,
    /// Direction of its axis in three dimensions (no unit); without this key in the plane.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![0.0, 0.0, 1.0])]
    pub axis: Vec<f64>,
    /// Its angle, counterclockwise seen from the tip of the axis (degree).
    #[schemars(example = 20.0)]
    pub degrees: f64,
}

/// A region of space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Ball { centre: vec![0.0, 0.0], radius: 1.5 })]
#[schemars(example = Self::Surface { file: "projectile.stl".to_owned(), scale: 0.1, shift: vec![], read: None })]
#[schemars(example = Self::Points { file: "particles.csv".to_owned(), spacing: 0.05, read: None })]
pub enum SolidScene {
    /// A box.
    Box {
        /// The lowest corner (length of `units`).
        from: Vec<f64>,
        /// The highest corner (length of `units`).
        to: Vec<f64>,
    },
    /// A ball; a disk in two dimensions.
    Ball {
        /// Its centre (length of `units`).
        centre: Vec<f64>,
        /// Its radius (length of `units`).
        radius: f64,
    },
    /// A circular cylinder along the third axis, in three dimensions.
    Cylinder {
        /// The centre of its lower end (length of `units`).
        base: Vec<f64>,
        /// Its radius (length of `units`).
        radius: f64,
        /// Its height (length of `units`).
        height: f64,
    },
    /// A simple polygon, in two dimensions.
    Polygon {
        /// Its corners in the order of the boundary, each once, at least three (length of `units`).
        corners: Vec<Vec<f64>>,
    },
    /// What a surface of triangles encloses, in three dimensions.
    ///
    /// The surface is closed. A cavity is bounded by triangles of the opposite orientation.
    Surface {
        /// Path of an STL file, text or binary, from the folder of the scene.
        #[schemars(example = "projectile.stl")]
        file: String,
        /// Factor of its coordinates (no unit).
        #[serde(default = "one")]
        #[schemars(example = 0.1)]
        scale: f64,
        /// Shift along each axis, after scaling (length of `units`); none without this key.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(example = vec![0.0, 0.0, 1.5])]
        shift: Vec<f64>,
        /// The surface.
        #[serde(skip)]
        read: Option<Arc<Surface>>,
    },
    /// The particles themselves. They need not be on a lattice; the count of torn pairs takes those that are about a spacing apart.
    Points {
        /// Path of a file with their places from the folder of the scene: a column for each axis, separated by blanks or commas (length of
        /// `units`).
        #[schemars(example = "particles.csv")]
        file: String,
        /// Edge length of the box that each represents (length of `units`): its power by the dimension is the volume of a particle.
        #[schemars(example = 0.05)]
        spacing: f64,
        /// The places.
        #[serde(skip)]
        read: Option<Arc<PointList>>,
    },
}

/// The scale of a file in units of the scene.
const fn one() -> f64 {
    1.0
}

/// A random parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomScene {
    /// `material.part.name`, e.g. `steel.strength.a`, or the path of another number of bodies, boundaries, contact or gravity, e.g.
    /// `bodies[0].velocity[1]`; its mean is the value in the scene.
    pub parameter: String,
    /// Its probability distribution.
    pub law: LawScene,
    /// Coefficient of variation (no unit).
    pub coefficient_of_variation: f64,
}

/// Distributions of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LawScene {
    /// Normal; rejected if too much probability lies outside the admissible range.
    Normal,
    /// Lognormal.
    Lognormal,
}

/// A correlation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationScene {
    /// Two of the random parameters.
    pub between: [String; 2],
    /// From -1 to 1 (no unit).
    pub value: f64,
}

impl CorrelationScene {
    fn between_steel_parameters() -> Self {
        let between = ["steel.strength.a", "steel.strength.b"].map(str::to_owned);
        Self { between, value: 0.5 }
    }
}

/// A gauge; it moves with the material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GaugeScene {
    /// Its name.
    pub name: String,
    /// The name of its body.
    pub body: String,
    /// The point whose nearest particles are averaged (length of `units`). Either this or `within`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Vec<f64>>,
    /// The box, from its lowest to its highest corner, whose particles are averaged (length of `units`). Either this or `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<[Vec<f64>; 2]>,
}

/// Time of observation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum TimeScene {
    /// An instant (time of `units`).
    At(f64),
    /// The mean over a window, from and to (time of `units`).
    Mean([f64; 2]),
}

impl TimeScene {
    /// The time as a window.
    #[must_use]
    pub const fn window(self) -> Window {
        match self {
            Self::At(time) => Window::at(time),
            Self::Mean([from, to]) => Window { from, to },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene_runs::scene::SceneFile;
    use scene_runs::schema::defaults;

    #[test]
    fn the_defaults_that_the_schema_tells_are_those_of_the_solver() {
        let text = include_str!("../../../../tests/scenes/smpm/plate_impact.json").to_owned();
        let scene: SmpmScene = SceneFile::from_text("scene.json", text).unwrap().parse().unwrap();
        let told = defaults::<SchemeScene>();
        assert!(!told.is_empty());
        let with = |scheme| SmpmScene { scheme, ..scene.clone() }.config::<1>().unwrap();
        let usual = with(SchemeScene::default());
        assert_ne!(with(scene.scheme.clone()), usual);
        assert_eq!(with(serde_json::from_value(told.into()).unwrap()), usual);
    }
}
