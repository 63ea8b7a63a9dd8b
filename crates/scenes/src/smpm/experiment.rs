//! A scene as an experiment with random parameters.

use perturbation_moments::Scalar;
use smpm::uncertainty::Experiment;
use smpm::{Body, Config, Error, Fill, Number, Simulation};

use super::material_scene::{MaterialScene, Numbers, Part};
use super::reading::RandomParameter;
use super::scene::SmpmScene;
use crate::scene::Objection;

/// A parsed scene: initial particles, material parameters, and which of them are random.
#[derive(Debug)]
pub struct SceneExperiment<const D: usize> {
    config: Config<D>,
    bodies: Vec<Prepared<D>>,
    random: Vec<RandomParameter>,
}

#[derive(Debug)]
struct Prepared<const D: usize> {
    material_name: String,
    material: MaterialScene,
    numbers: Numbers,
    fill: Fill<D>,
    velocity: [f64; D],
}

impl<const D: usize> SceneExperiment<D> {
    /// Parses a scene.
    ///
    /// # Errors
    /// Those of the check of the scene.
    pub fn new(scene: &SmpmScene) -> Result<Self, Objection> {
        let all = scene.numbers()?;
        let prepare = |(i, body): (usize, &super::scene::BodyScene)| {
            let (Some(material), Some(numbers)) =
                (scene.materials.get(&body.material), all.get(body.material.as_str()))
            else {
                let message = format!("there is no material `{}`", body.material);
                return Err(Objection::new(format!("bodies[{i}].material"), message));
            };
            Ok(Prepared {
                material_name: body.material.clone(),
                material: material.clone(),
                numbers: numbers.clone(),
                fill: scene.fill(i)?,
                velocity: body.velocity.as_slice().try_into().unwrap_or([0.0; D]),
            })
        };
        Ok(Self {
            config: scene.config()?,
            bodies: scene.bodies.iter().enumerate().map(prepare).collect::<Result<_, _>>()?,
            random: scene.random_parameters()?,
        })
    }

    /// Number of particles.
    #[must_use]
    pub fn n_particles(&self) -> usize {
        self.bodies.iter().map(|body| body.fill.positions.len()).sum()
    }
}

impl<const D: usize, const N: usize> Experiment<D, N> for SceneExperiment<D> {
    fn simulation<S: Number>(&self, x: &[S; N]) -> Result<Simulation<S, D>, Error> {
        let body = |prepared: &Prepared<D>| -> Result<Body<S, D>, Error> {
            let of = |part: Part, name: &'static str| -> S {
                let random = self.random.iter().zip(x).find(|(random, _)| {
                    random.key == (part, name) && random.material == prepared.material_name
                });
                match random {
                    Some((_, &value)) => value,
                    None => <S as Scalar>::constant(prepared.numbers[&(part, name)]),
                }
            };
            prepared.material.body(&of, &prepared.fill, prepared.velocity)
        };
        let bodies = self.bodies.iter().map(body).collect::<Result<_, _>>()?;
        Simulation::new(self.config.clone(), bodies)
    }
}
