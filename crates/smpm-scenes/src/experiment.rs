//! A scene as an experiment with random inputs: parameters, or coefficients of random fields.

use perturbation_moments::{RandomVector, Scalar};
use scene_runs::scene::Objection;
use smpm::uncertainty::{Coefficients, Experiment, Inputs};
use smpm::{Body, Config, Error, Fill, Number, Simulation, SurfaceLoad};

use super::load_scene::loads_of;
use super::material_scene::{MaterialPart, MaterialScene, Numbers};
use super::numbers::{NumberAt, moved};
use super::random_fields::PreparedField;
use super::reading::{MOST_RANDOM, RandomParameter, Varied};
use super::region::BodyRegion;
use super::scene::SmpmScene;

/// A parsed scene: initial particles, material parameters, and which of them are random.
#[derive(Debug)]
pub struct SceneExperiment<const D: usize> {
    scene: SmpmScene,
    config: Config<D>,
    bodies: Vec<Prepared<D>>,
    fills: Vec<Fill<D>>,
    random: Vec<RandomParameter>,
    parameters: RandomVector<MOST_RANDOM>,
    fields: Vec<PreparedField>,
}

#[derive(Debug)]
struct Prepared<const D: usize> {
    material_name: String,
    material: MaterialScene,
    numbers: Numbers,
    velocity: [f64; D],
    is_rigid: bool,
    loads: Vec<SurfaceLoad<D>>,
}

impl<const D: usize> SceneExperiment<D> {
    /// Parses a scene.
    ///
    /// # Errors
    /// Those of the check of the scene.
    pub fn new(scene: &SmpmScene) -> Result<Self, Objection> {
        let all = scene.numbers()?;
        let mut fills = Vec::new();
        let prepare = |(i, body): (usize, &super::scene::BodyScene)| {
            let (Some(material), Some(numbers)) =
                (scene.materials.get(&body.material), all.get(body.material.as_str()))
            else {
                let message = format!("there is no material `{}`", body.material);
                return Err(Objection::new(format!("bodies[{i}].material"), message));
            };
            fills.push(scene.fill(i)?);
            Ok(Prepared {
                material_name: body.material.clone(),
                material: material.clone(),
                numbers: numbers.clone(),
                velocity: body.velocity.as_slice().try_into().unwrap_or([0.0; D]),
                is_rigid: body.rigid,
                loads: loads_of(&body.loads, body.rigid, &format!("bodies[{i}]"))?,
            })
        };
        let bodies = scene.bodies.iter().enumerate().map(prepare).collect::<Result<_, _>>()?;
        let fields = scene.prepared_fields(&fills)?;
        let (config, random) = (scene.config()?, scene.random_parameters()?);
        let (scene, parameters) = (scene.clone(), scene.inputs()?);
        Ok(Self { scene, config, bodies, fills, random, parameters, fields })
    }

    /// The experiment with other numbers beside the constants of materials; `None` where these alone are random.
    fn with_numbers<S: Number>(&self, x: &[S]) -> Option<Result<Self, Objection>> {
        let of = |(random, value): (&'_ RandomParameter, &S)| match &random.varied {
            Varied::Constant { .. } => None,
            Varied::Number { path } => Some((path.clone(), value.value())),
        };
        let numbers: Vec<(String, f64)> = self.random.iter().zip(x).filter_map(of).collect();
        (!numbers.is_empty()).then(|| {
            let numbers: Vec<NumberAt<'_>> =
                numbers.iter().map(|(path, value)| (path.as_str(), *value)).collect();
            self.at_numbers(&numbers)
        })
    }

    /// The experiment with other numbers at paths. Every body keeps its particles: those of another size or rotation are moved.
    ///
    /// # Errors
    /// An [`Objection`] to a number with which the scene cannot be.
    pub(crate) fn at_numbers(&self, numbers: &[NumberAt<'_>]) -> Result<Self, Objection> {
        let scene = self.scene.with_numbers(numbers)?;
        let mut varied = Self::new(&scene)?;
        varied.fills.clone_from(&self.fills);
        let of_bodies = numbers.iter().filter_map(|(path, _)| self.scene.moved_body(path));
        let of_bodies: Vec<usize> = of_bodies.map(|(number, _)| number).collect();
        for &b in &of_bodies {
            let region =
                |scene: &SmpmScene| BodyRegion::of(&scene.bodies[b], &format!("bodies[{b}]"));
            varied.fills[b] = moved(&self.fills[b], &region(&self.scene)?, &region(&scene)?);
        }
        if !of_bodies.is_empty() {
            scene.check_bodies::<D>()?;
        }
        Ok(varied)
    }

    /// The random inputs: coefficients of the fields, or parameters where there are none.
    #[must_use]
    pub fn inputs(&self) -> Box<dyn Inputs> {
        match self.n_coefficients() {
            0 => self.parameters.into(),
            n => Coefficients(n).into(),
        }
    }

    /// Number of coefficients of all random fields.
    pub(super) fn n_coefficients(&self) -> usize {
        self.fields.iter().map(|field| field.n_terms).sum()
    }

    /// Number of random parameters or coefficients.
    pub(super) fn n_random(&self) -> usize {
        self.random.len() + self.n_coefficients()
    }

    /// The random fields: their constants, terms, and the variance that the terms leave out, mean and largest.
    pub(super) fn fields(&self) -> &[PreparedField] {
        &self.fields
    }

    /// The constants that vary, of every particle of all bodies in order: name and values, not a number outside of the material.
    pub(super) fn constants(&self, coefficients: &[f64]) -> Vec<(String, Vec<f64>)> {
        let mut columns = Vec::new();
        for field in &self.fields {
            for (&key, name) in field.keys.iter().zip(&field.parameters) {
                let mut column = Vec::with_capacity(self.n_particles());
                for (b, body) in self.bodies.iter().enumerate() {
                    let factors = field.factors(b, coefficients);
                    if factors.is_empty() {
                        column.extend(std::iter::repeat_n(f64::NAN, self.fills[b].positions.len()));
                    } else {
                        column.extend(factors.iter().map(|factor| body.numbers[&key] * factor));
                    }
                }
                columns.push((name.clone(), column));
            }
        }
        columns
    }

    /// Number of particles.
    #[must_use]
    pub fn n_particles(&self) -> usize {
        self.fills.iter().map(|fill| fill.positions.len()).sum()
    }
}

impl<const D: usize> Experiment<D> for SceneExperiment<D> {
    fn simulation<S: Number>(&self, x: &[S]) -> Result<Simulation<S, D>, Error> {
        let (value, expected) = (x.len(), self.inputs().n_normals());
        if value != expected {
            return Err(Error::OtherInputs { value, expected });
        }
        match self.with_numbers(x) {
            None => self.of_constants(x),
            Some(Ok(varied)) => varied.of_constants(x),
            Some(Err(objection)) => Err(Error::InputsRefused { reason: objection.to_string() }),
        }
    }
}

impl<const D: usize> SceneExperiment<D> {
    /// The simulation at its start, by the constants of materials among the inputs.
    fn of_constants<S: Number>(&self, x: &[S]) -> Result<Simulation<S, D>, Error> {
        let body = |(b, (prepared, fill)): (usize, (&Prepared<D>, &Fill<D>))| {
            let own = self.fields.iter().filter(|field| field.material == prepared.material_name);
            let factors: Vec<(&PreparedField, Vec<S>)> =
                own.map(|field| (field, field.factors(b, x))).collect();
            let of = |particle: usize, part: MaterialPart, name: &'static str| -> S {
                let random = self.random.iter().zip(x).find(|(random, _)| match &random.varied {
                    Varied::Constant { material, key } => {
                        *key == (part, name) && *material == prepared.material_name
                    }
                    Varied::Number { .. } => false,
                });
                if let Some((_, &value)) = random {
                    return value;
                }
                let constant = <S as Scalar>::constant(prepared.numbers[&(part, name)]);
                let varies = factors.iter().find(|(field, _)| field.keys.contains(&(part, name)));
                varies.map_or(constant, |(_, factors)| constant * factors[particle])
            };
            let model = |particle: usize| {
                prepared
                    .material
                    .model(&|part: MaterialPart, name: &'static str| of(particle, part, name))
            };
            let body = if factors.is_empty() {
                Body::new(model(0)?, fill, prepared.velocity)
            } else {
                Body::varying(|particle, _| Ok(model(particle)?), fill, prepared.velocity)
            };
            let body = body?.loaded(&prepared.loads)?;
            Ok(if prepared.is_rigid { body.rigid() } else { body })
        };
        let bodies = self.bodies.iter().zip(&self.fills).enumerate().map(body);
        Simulation::new(self.config.clone(), bodies.collect::<Result<_, Error>>()?)
    }
}
