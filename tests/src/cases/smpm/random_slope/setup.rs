//! The built-in slope under growing weight: what a run changes of it, and its factor of safety.

use perturbation_moments::MonteCarlo;
use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::experiment::SceneExperiment;
use scenes::smpm::material_scene::StrengthScene;
use scenes::smpm::method_scene::MethodScene;
use scenes::smpm::reading::MOST_RANDOM;
use scenes::smpm::scene::{SmpmScene, SolidScene};
use smpm::Simulation;
use smpm::uncertainty::Experiment;

use super::factor::Slide;
use crate::cases::prelude::*;

/// Gravity of the scene (m/s^2).
const GRAVITY: f64 = 9.81;
/// Multiple of gravity from which on it grows slowly, and the time until then (s): a dozen periods of the layer.
const BEFORE: f64 = 0.7;
const UNTIL: f64 = 1.0;
/// Multiple of gravity at which a run ends: no slope of the scene has such a factor.
const MOST: f64 = 3.0;
/// Von Mises stress over shear stress in plane strain without change of volume.
const YIELD_OF_SHEAR: f64 = 1.732_050_807_568_877_2;

/// How the factor of the slope is found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setup {
    /// Edge of a cell (m).
    pub(super) cell: f64,
    /// Particles along it.
    pub(super) particles_per_cell: u32,
    /// Multiples of gravity by which it grows in a second.
    pub(super) rate: f64,
    /// Stiffness over that of the scene.
    pub(super) stiffness: f64,
    /// Displacements between which the factor is read (m).
    pub(super) displacements: [f64; 2],
}

impl Setup {
    /// What the cases use, chosen on the slope with uniform strength.
    pub(super) const USUAL: Self = Self {
        cell: 0.5,
        particles_per_cell: 1,
        rate: 0.1,
        stiffness: 1.0,
        displacements: [0.03, 0.05],
    };

    /// The usual one in a few words.
    pub(super) fn words(&self) -> String {
        format!(
            "cells of {} m, {} particle(s) along the edge, gravity grows by {} of its value a second, stiffness x {}, sliding from {} to {} m",
            self.cell,
            self.particles_per_cell,
            self.rate,
            self.stiffness,
            self.displacements[0],
            self.displacements[1]
        )
    }

    /// The built-in scene so changed.
    pub(super) fn scene(&self) -> CaseResult<SmpmScene> {
        let mut scene = Problem::RandomSlope.scene()?;
        scene.grid.cell = self.cell;
        scene.grid.particles_per_cell = self.particles_per_cell;
        scene.gravity = vec![0.0, -GRAVITY];
        scene.gravity_history = vec![[0.0, 0.0], [UNTIL, BEFORE], [self.end(), MOST]];
        self.stiffen(&mut scene)?;
        Ok(scene)
    }

    fn end(&self) -> f64 {
        UNTIL + (MOST - BEFORE) / self.rate
    }

    fn stiffen(&self, scene: &mut SmpmScene) -> CaseResult<()> {
        let clay = scene.materials.get_mut("clay").ok_or("the scene has no clay")?;
        let scenes::smpm::material_scene::EquationScene::MieGruneisen(equation) =
            &mut clay.equation
        else {
            return Err("the clay has another equation of state".into());
        };
        let sound = equation.set.get_mut("sound_speed").ok_or("no speed of sound")?;
        *sound *= self.stiffness.sqrt();
        let Some(StrengthScene::VonMises(strength)) = &mut clay.strength else {
            return Err("the clay has another strength".into());
        };
        *strength.set.get_mut("shear_modulus").ok_or("no shear modulus")? *= self.stiffness;
        Ok(())
    }

    fn slide(&self) -> Slide {
        // Some five looks while the slope slides so far.
        let interval = 0.02;
        Slide { displacements: self.displacements, interval, gravity: GRAVITY }
    }

    fn factor_of(&self, run: &mut Simulation<f64, 2>) -> CaseResult<f64> {
        let found = self.slide().factor(run, self.end())?;
        found.ok_or_else(|| format!("the slope holds {MOST} times its weight").into())
    }

    /// The factor of a uniform slope of a strength (Pa).
    pub(super) fn uniform(&self, strength: f64) -> CaseResult<f64> {
        self.uniform_of(self.scene()?, strength)
    }

    /// The factor of a vertical cut of the height of the slope, with the soil below it, by the same means.
    pub(super) fn vertical_cut(&self, strength: f64) -> CaseResult<f64> {
        let mut scene = self.scene()?;
        let corners = [[0.0, -2.5], [14.0, -2.5], [14.0, 0.0], [8.0, 0.0], [8.0, 5.0], [0.0, 5.0]];
        let corners = corners.iter().map(|corner| corner.to_vec()).collect();
        scene.bodies[0].shape = SolidScene::Polygon { corners };
        for (boundary, position) in scene.boundaries.iter_mut().zip([0.0, 14.0, -2.5]) {
            boundary.position = position;
        }
        self.uniform_of(scene, strength)
    }

    fn uniform_of(&self, mut scene: SmpmScene, strength: f64) -> CaseResult<f64> {
        scene.random_fields.clear();
        scene.method = MethodScene::Deterministic;
        if let Some(StrengthScene::VonMises(of_clay)) =
            scene.materials.get_mut("clay").and_then(|clay| clay.strength.as_mut())
        {
            of_clay.set.insert("yield_stress".to_owned(), YIELD_OF_SHEAR * strength);
        }
        let experiment = experiment::<2>(&scene)?;
        let mut run = Experiment::simulation::<f64>(&experiment, &[0.0; MOST_RANDOM])?;
        self.factor_of(&mut run)
    }
}

/// Realisations of the slope by one setup.
pub(super) struct Realisations {
    setup: Setup,
    experiment: SceneExperiment<2>,
    normals: MonteCarlo,
}

impl Realisations {
    pub(super) fn new(setup: Setup, seed: u64) -> CaseResult<Self> {
        let experiment = experiment::<2>(&setup.scene()?)?;
        Ok(Self { setup, experiment, normals: MonteCarlo { seed, n_samples: 0 } })
    }

    /// The coefficients of a realisation: the same field by every setup.
    pub(super) fn coefficients(&self, realisation: u64) -> Vec<f64> {
        let mut normals = vec![0.0; self.experiment.inputs().n_normals()];
        self.normals.fill_normals(realisation, &mut normals);
        normals
    }

    /// The factor of a realisation.
    pub(super) fn factor(&self, realisation: u64) -> CaseResult<f64> {
        let coefficients = self.coefficients(realisation);
        let mut run = Experiment::simulation::<f64>(&self.experiment, &coefficients)?;
        self.setup.factor_of(&mut run)
    }
}
