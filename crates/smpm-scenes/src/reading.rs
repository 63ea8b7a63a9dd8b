//! Conversion of a scene: distributions, configuration, plan and bodies, with their checks.

use std::collections::BTreeMap;
use std::path::Path;

use perturbation_moments::{Marginal, RandomVector};
use scene_runs::scene::{
    NamedFile, Objection, Retired, Scene, SceneError, SceneFile, WrongKey, read_keys,
};
use serde_json::Value;
use smpm::{
    Boundary, BoundaryKind, BulkViscosity, Config, Contact, Fill, Gauge, Geometry, Place, Plan,
    Quantity, Shape, Side, Transfer,
};
use uq_estimators::{Error as SamplingError, SobolPoints};

use super::coordinates::point;
use super::load_scene::{check_history, loads_of};
use super::material_scene::{MaterialPart, MaterialScene, Numbers};
use super::method_scene::MethodScene;
use super::numbers::is_path;
use super::region::BodyRegion;
use super::retired::RETIRED;
use super::scene::{
    BoundaryKindScene, BoundaryScene, ContactScene, CorrelationScene, GaugeScene, LawScene,
    ShapeScene, SideScene, SmpmScene, TransferScene,
};

/// A random parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomParameter {
    /// What it is.
    pub varied: Varied,
    /// Its mean.
    pub mean: f64,
}

/// What varies from run to run.
#[derive(Debug, Clone, PartialEq)]
pub enum Varied {
    /// A constant of a material.
    Constant {
        /// The name of the material.
        material: String,
        /// Key of the constant.
        key: (MaterialPart, &'static str),
    },
    /// Any other number of the scene: a velocity, a size, a friction coefficient.
    Number {
        /// Its path, e.g. `bodies[0].velocity[1]`.
        path: String,
    },
}

/// Largest number of random parameters of a scene: the lanes of a jet.
pub const MOST_RANDOM: usize = 8;

/// Fewest samples of a mean and a variance with their errors.
pub(crate) const FEWEST_SAMPLES: u64 = 8;

/// Largest lattice of a body in a scene, including points outside of the body.
///
/// It is some sixty times the largest scene run here.
///
/// A typing error in the cell size gives many more, and is reported before they are created.
const MOST_PLACES: f64 = 1e7;

/// Most triangles that are visited to fill a body: some seconds.
const MOST_VISITS: f64 = 2e8;

impl SmpmScene {
    /// The parameters of every material.
    ///
    /// # Errors
    /// An [`Objection`] to a missing or unknown parameter.
    pub fn numbers(&self) -> Result<BTreeMap<&str, Numbers>, Objection> {
        let units = self.units.units()?;
        let read = |(name, material): (&'_ String, &MaterialScene)| {
            material.numbers(units, &format!("materials.{name}"))
        };
        self.materials.iter().map(|entry| Ok((entry.0.as_str(), read(entry)?))).collect()
    }

    /// The files that it names, once they are read.
    pub(crate) fn files(&self) -> Vec<NamedFile> {
        let files =
            self.materials.values().filter_map(|it| it.keyword_file.as_ref()?.read.as_ref());
        files.map(|(file, _)| file.clone()).chain(self.shape_files()).collect()
    }

    /// The random parameters, in order.
    ///
    /// # Errors
    /// An [`Objection`] to an unknown or duplicate name, and to too many of them.
    pub fn random_parameters(&self) -> Result<Vec<RandomParameter>, Objection> {
        if self.random.len() > MOST_RANDOM {
            let n = self.random.len();
            let message = format!("{n} random parameters; a scene may have {MOST_RANDOM}");
            return Err(Objection::new("random", message));
        }
        let numbers = self.numbers()?;
        let mut found: Vec<RandomParameter> = Vec::new();
        for (i, random) in self.random.iter().enumerate() {
            let path = format!("random[{i}].parameter");
            let (varied, mean) = self.varied(&random.parameter, &numbers, &path)?;
            if found.iter().any(|earlier| earlier.varied == varied) {
                let message = format!("`{}` is given twice", random.parameter);
                return Err(Objection::new(path, message));
            }
            if mean == 0.0 && random.coefficient_of_variation > 0.0 {
                let message = format!(
                    "`{}` is 0: a coefficient of variation gives it no deviation",
                    random.parameter
                );
                let help = "give the parameter a value under `set`, or leave it out of `random`";
                return Err(Objection::new(path, message).with_help(help));
            }
            found.push(RandomParameter { varied, mean });
        }
        Ok(found)
    }

    /// The constant or number of a name, and its value.
    fn varied(
        &self,
        name: &str,
        numbers: &BTreeMap<&str, Numbers>,
        path: &str,
    ) -> Result<(Varied, f64), Objection> {
        let (material, key) = name.split_once('.').unwrap_or((name, ""));
        if let Some(of_material) = numbers.get(material) {
            let key = MaterialScene::parameter(of_material, key, path)?;
            let varied = Varied::Constant { material: material.to_owned(), key };
            return Ok((varied, of_material[&key]));
        }
        if is_path(name) {
            let mean = self.number(name, path)?;
            return Ok((Varied::Number { path: name.to_owned() }, mean));
        }
        Err(Objection::unknown(path, "material", material, self.materials.keys()))
    }

    /// Rejects methods by derivatives where a number varies that has none.
    fn check_number_methods(&self) -> Result<(), Objection> {
        let has_derivatives =
            matches!(self.method, MethodScene::Propagated | MethodScene::Frozen { .. });
        let is_number = |random: &RandomParameter| matches!(random.varied, Varied::Number { .. });
        let random = self.random_parameters()?;
        let Some(i) = random.iter().position(is_number).filter(|_| has_derivatives) else {
            return Ok(());
        };
        let message = format!(
            "`{}`: this method has derivatives by constants of materials alone",
            self.random[i].parameter
        );
        let help = "take `finite_difference`, `sigma_points`, `monte_carlo` or `quasi_monte_carlo`";
        Err(Objection::new(format!("random[{i}].parameter"), message).with_help(help))
    }

    /// The joint distribution of the parameters: those of the scene, then certain ones.
    ///
    /// # Errors
    /// An [`Objection`] to a correlation, or to an invalid random vector.
    pub fn inputs(&self) -> Result<RandomVector<MOST_RANDOM>, Objection> {
        let parameters = self.random_parameters()?;
        let (mut mean, mut deviations) = ([1.0; MOST_RANDOM], [0.0; MOST_RANDOM]);
        let mut marginals = [Marginal::Normal; MOST_RANDOM];
        for (i, (parameter, random)) in parameters.iter().zip(&self.random).enumerate() {
            mean[i] = parameter.mean;
            deviations[i] = random.coefficient_of_variation * parameter.mean.abs();
            if random.law == LawScene::Lognormal {
                marginals[i] = Marginal::Lognormal;
            }
        }
        let mut correlation = [[0.0; MOST_RANDOM]; MOST_RANDOM];
        for (i, row) in correlation.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        for (c, given) in self.correlations.iter().enumerate() {
            let path = format!("correlations[{c}]");
            let place = |name: &String| {
                self.random.iter().position(|random| random.parameter == *name).ok_or_else(|| {
                    let names = self.random.iter().map(|random| &random.parameter);
                    Objection::unknown(format!("{path}.between"), "random parameter", name, names)
                })
            };
            let [i, j] = [place(&given.between[0])?, place(&given.between[1])?];
            if i == j {
                let message = "a parameter is correlated with itself";
                return Err(Objection::new(format!("{path}.between"), message));
            }
            let is_it = |earlier: &CorrelationScene| {
                given.between.iter().all(|name| earlier.between.contains(name))
            };
            if self.correlations[..c].iter().any(is_it) {
                let message = "the correlation of these two parameters is given twice";
                return Err(Objection::new(format!("{path}.between"), message));
            }
            (correlation[i][j], correlation[j][i]) = (given.value, given.value);
        }
        let refused = |error: perturbation_moments::Error| {
            let path = if self.correlations.is_empty() { "random" } else { "correlations" };
            Objection::new(path, error.to_string())
        };
        RandomVector::new(mean, deviations, correlation)
            .and_then(|inputs| inputs.with_marginals(marginals))
            .map_err(refused)
    }

    /// The configuration of the solver.
    ///
    /// # Errors
    /// An [`Objection`] to a vector whose number of components is not the dimension of the scene.
    pub fn config<const D: usize>(&self) -> Result<Config<D>, Objection> {
        let usual = Config::with_cell(self.grid.cell);
        let scheme = &self.scheme;
        let viscosity = scheme.viscosity.map_or(usual.viscosity, |given| BulkViscosity {
            quadratic: given.quadratic,
            linear: given.linear,
        });
        Ok(Config {
            shape: scheme.shape.map_or(usual.shape, |shape| match shape {
                ShapeScene::QuadraticBSpline => Shape::QuadraticBSpline,
                ShapeScene::CubicBSpline => Shape::CubicBSpline,
            }),
            transfer: scheme.transfer.map_or(usual.transfer, |transfer| match transfer {
                TransferScene::Apic => Transfer::Apic,
                TransferScene::Flip {} => Transfer::Flip,
            }),
            viscosity,
            courant_number: scheme.courant_number.unwrap_or(usual.courant_number),
            damping: scheme.damping.unwrap_or(usual.damping),
            geometry: if self.axisymmetric { Geometry::Axisymmetric } else { Geometry::Cartesian },
            boundaries: self.boundaries.iter().map(BoundaryScene::boundary).collect(),
            contact: match self.contact {
                ContactScene::Bonded => Contact::Bonded,
                ContactScene::Friction { coefficient } => Contact::Friction { coefficient },
            },
            gravity: match self.gravity.as_slice() {
                [] => [0.0; D],
                given => point(given, "gravity")?,
            },
            gravity_history: self.gravity_history.clone(),
            ..usual
        })
    }

    /// The observed quantities of a checked scene.
    ///
    /// # Errors
    /// An [`Objection`] to a name or a point.
    pub fn plan<const D: usize>(&self) -> Result<Plan<D>, Objection> {
        let gauge = |(i, gauge): (usize, &GaugeScene)| {
            let path = format!("gauges[{i}]");
            let names = || self.bodies.iter().map(|body| &body.name);
            let body = names().position(|name| *name == gauge.body).ok_or_else(|| {
                Objection::unknown(format!("{path}.body"), "body", &gauge.body, names())
            })?;
            let place = match (&gauge.at, &gauge.within) {
                (Some(at), None) => Place::Nearest(point(at, &format!("{path}.at"))?),
                (None, Some([from, to])) => Place::Region {
                    from: point(from, &format!("{path}.within[0]"))?,
                    to: point(to, &format!("{path}.within[1]"))?,
                },
                _ => {
                    let message = "a gauge needs one of `at` and `within`";
                    return Err(Objection::new(path, message));
                }
            };
            Ok(Gauge { name: gauge.name.clone(), body, place })
        };
        Ok(Plan {
            gauges: self.gauges.iter().enumerate().map(gauge).collect::<Result<_, _>>()?,
            quantities: self.quantities()?,
            windows: self.times.iter().map(|time| time.window()).collect(),
        })
    }

    fn quantities(&self) -> Result<Vec<Quantity>, Objection> {
        let quantity = |(i, name): (usize, &String)| {
            name.parse::<Quantity>().map_err(|error| {
                let names: Vec<String> = Quantity::all().map(|q| q.to_string()).collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let message = format!("there is no quantity `{name}`");
                Objection::new(format!("quantities[{i}]"), message).with_nearest(
                    name,
                    &names,
                    || error.to_string(),
                )
            })
        };
        self.quantities.iter().enumerate().map(quantity).collect()
    }

    /// The initial particles of a body.
    ///
    /// # Errors
    /// An [`Objection`] to a point of another dimension, and to a lattice of more than 10^7 points, or one that takes too long to fill.
    pub fn fill<const D: usize>(&self, body: usize) -> Result<Fill<D>, Objection> {
        let path = format!("bodies[{body}]");
        let region = BodyRegion::<D>::of(&self.bodies[body], &path)?;
        let spacing = [self.grid.cell / f64::from(self.grid.particles_per_cell); D];
        if let Some(listed) = region.listed() {
            return Ok(listed);
        }
        let (low, high) = region.lattice(spacing[0]);
        let along = |k: usize| ((high[k] - low[k]) / spacing[k]).max(1.0);
        let places: f64 = (0..D).map(along).product();
        if places > MOST_PLACES {
            let message = format!(
                "{path}: {places:.3e} lattice points for particles; at most {MOST_PLACES:e}"
            );
            return Err(Objection::new("grid.cell", message));
        }
        let visits = places * region.n_visited();
        if visits > MOST_VISITS {
            let message = format!(
                "{path}: {visits:.3e} triangles to compare with points; at most {MOST_VISITS:e}"
            );
            let help = "take a larger cell, or a surface of fewer triangles that are not as long";
            return Err(Objection::new("grid.cell", message).with_help(help));
        }
        Fill::of(spacing, (low, high), |x| region.holds(x))
            .map_err(|error| Objection::new("grid.cell", format!("{path}: {error}")))
    }
}

impl BoundaryScene {
    fn boundary(&self) -> Boundary {
        Boundary {
            axis: self.axis.wrapping_sub(1),
            position: self.position,
            side: match self.side {
                SideScene::Above => Side::Above,
                SideScene::Below => Side::Below,
            },
            kind: match self.kind {
                BoundaryKindScene::Symmetry => BoundaryKind::Symmetry,
                BoundaryKindScene::Clamped => BoundaryKind::Clamped,
                BoundaryKindScene::Rigid => BoundaryKind::Rigid { friction: 0.0 },
                BoundaryKindScene::Frictional { friction } => BoundaryKind::Rigid { friction },
                BoundaryKindScene::Absorbing { longitudinal, shear } => {
                    BoundaryKind::Absorbing { longitudinal, shear }
                }
            },
        }
    }
}

impl SmpmScene {
    /// Parses a text; messages refer to it by name.
    ///
    /// # Errors
    /// Those of [`SceneFile::parse`].
    pub fn read(name: &str, text: &str) -> Result<Self, SceneError> {
        SceneFile::from_text(name, text.to_owned())?.parse()
    }
}

impl Scene for SmpmScene {
    type Built = ();
    const RETIRED: &[Retired] = RETIRED;

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn read_files(&mut self, folder: &Path) -> Result<(), Objection> {
        let units = self.units.units()?;
        for (name, material) in &mut self.materials {
            material.read_file(folder, &units, &format!("materials.{name}"))?;
        }
        self.read_shapes(folder)
    }

    fn check(&self) -> Result<(), Objection> {
        if self.gauges.is_empty() || self.quantities.is_empty() || self.times.is_empty() {
            let message = "gauges, quantities and times need one entry each at least";
            return Err(Objection::new("", message));
        }
        if self.grid.particles_per_cell == 0 {
            let message = "no particle fits into a cell; at least 1 along its edge is needed";
            return Err(Objection::new("grid.particles_per_cell", message));
        }
        if self.grid.cell.is_nan() || self.grid.cell <= 0.0 {
            let message = format!("the cell is {} and must be greater than 0", self.grid.cell);
            return Err(Objection::new("grid.cell", message));
        }
        self.check_boundaries()?;
        self.check_gravity_history()?;
        self.quantities()?;
        for name in self.levels.keys() {
            if !self.quantities.contains(name) {
                return Err(Objection::unknown("levels", "quantity", name, self.quantities.iter()));
            }
        }
        self.check_field_method()?;
        for (i, random) in self.random.iter().enumerate() {
            let value = random.coefficient_of_variation;
            if !(value >= 0.0 && value.is_finite()) {
                let message =
                    format!("the coefficient of variation is {value} and must not be negative");
                return Err(Objection::new(
                    format!("random[{i}].coefficient_of_variation"),
                    message,
                ));
            }
        }
        if let MethodScene::MonteCarlo { samples, .. } = self.method
            && samples < FEWEST_SAMPLES
        {
            let message = format!(
                "{samples} samples; a variance with an error needs at least {FEWEST_SAMPLES}"
            );
            return Err(Objection::new("method.monte_carlo.samples", message));
        }
        self.check_design()?;
        self.check_multilevel()?;
        match self.dimension {
            1 => self.check_in::<1>(),
            2 => self.check_in::<2>(),
            3 => self.check_in::<3>(),
            other => {
                let message = format!("{other} dimensions; there must be 1 to 3");
                Err(Objection::new("dimension", message))
            }
        }
    }

    fn seed(&mut self) -> Option<&mut u64> {
        self.method.seed_mut()
    }
}

impl SmpmScene {
    /// Axes that exist, and one kind of boundary in a plane.
    fn check_boundaries(&self) -> Result<(), Objection> {
        for (i, boundary) in self.boundaries.iter().enumerate() {
            let path = format!("boundaries[{i}]");
            if !(1..=self.dimension).contains(&boundary.axis) {
                let message = format!("axis {}; axes are 1 to {}", boundary.axis, self.dimension);
                return Err(Objection::new(format!("{path}.axis"), message));
            }
            if let BoundaryKindScene::Frictional { friction } = boundary.kind
                && (friction.is_nan() || friction < 0.0)
            {
                let message =
                    format!("the friction coefficient is {friction}; it must be 0 or above");
                return Err(Objection::new(format!("{path}.kind.frictional.friction"), message)
                    .with_help("write a coefficient such as 0.3"));
            }
            let plane = |of: &BoundaryScene| (of.axis, (of.position + 0.0).to_bits(), of.side);
            let earlier = self.boundaries[..i].iter().position(|of| plane(of) == plane(boundary));
            if let Some(earlier) = earlier {
                let message =
                    format!("boundaries[{earlier}] is in the same plane, on the same side");
                return Err(Objection::new(path, message).with_help("keep one of them"));
            }
        }
        Ok(())
    }

    /// Points of time in ascending order, if there is gravity.
    fn check_gravity_history(&self) -> Result<(), Objection> {
        if self.gravity.is_empty() && !self.gravity_history.is_empty() {
            let message = "there is no `gravity` of which to take multiples";
            return Err(Objection::new("gravity_history", message));
        }
        check_history(&self.gravity_history, "gravity_history")
    }

    /// Replicas of Sobol' points, of which there are only certain numbers.
    fn check_design(&self) -> Result<(), Objection> {
        let (name, points) = match self.method {
            MethodScene::QuasiMonteCarlo { points, .. } => ("quasi_monte_carlo", points),
            MethodScene::SobolIndices { points, .. } => ("sobol_indices", points),
            _ => return Ok(()),
        };
        let path = format!("method.{name}");
        if self.random.is_empty() {
            let message = "there are no random parameters to sample";
            return Err(Objection::new(path, message).with_help("add some under `random`"));
        }
        let is_of_indices = matches!(self.method, MethodScene::SobolIndices { .. });
        if let Some(c) = self.correlations.iter().position(|it| it.value != 0.0)
            && is_of_indices
        {
            let message = "Sobol' indices are shares of the variance for independent parameters; these are correlated";
            let help =
                "leave the correlation out, or take `quasi_monte_carlo` for mean and variance";
            return Err(Objection::new(format!("correlations[{c}]"), message).with_help(help));
        }
        let Some(Err(error)) = self.design().map(|design| design.n_runs()) else {
            return Ok(());
        };
        let objection = |key: &str| Objection::new(format!("{path}.{key}"), error.to_string());
        if let smpm::Error::Sampling(
            SamplingError::TooFew { quantity: "replicas", .. }
            | SamplingError::TooMany { quantity: "replicas", .. },
        ) = error
        {
            return Err(objection("replicas"));
        }
        // The powers of two around it.
        let above = points.clamp(3, SobolPoints::MOST_POINTS).next_power_of_two();
        Err(objection("points").with_help(format!("write {} or {above}", above / 2)))
    }

    /// Checks that depend on the dimension: points, gauges, and every material by itself.
    fn check_in<const D: usize>(&self) -> Result<(), Objection> {
        self.check_names()?;
        self.inputs()?;
        self.check_number_methods()?;
        self.check_sweep()?;
        self.plan::<D>()?;
        let numbers = self.numbers()?;
        for (name, material) in &self.materials {
            let path = format!("materials.{name}");
            let of = |part, key| numbers[name.as_str()][&(part, key)];
            material.model::<f64>(&of).map_err(|error| Objection::new(&path, error.to_string()))?;
        }
        for (i, body) in self.bodies.iter().enumerate() {
            if !self.materials.contains_key(&body.material) {
                let path = format!("bodies[{i}].material");
                return Err(Objection::unknown(
                    &path,
                    "material",
                    &body.material,
                    self.materials.keys(),
                ));
            }
            if !body.velocity.is_empty() {
                point::<D>(&body.velocity, &format!("bodies[{i}].velocity"))?;
            }
            loads_of::<D>(&body.loads, body.rigid, &format!("bodies[{i}]"))?;
        }
        self.check_bodies::<D>()?;
        self.check_fields::<D>()
    }
}
