//! A scene on grids of doubling cells, as the levels of a multilevel estimate.

use perturbation_moments::{MonteCarlo, RandomVector};
use smpm::uncertainty::{Experiment, FieldExperiment, FieldStudy, Keep, Study};
use smpm::{Error, Plan};
use uq_estimators::{Failure, Ladder, Pair};

use crate::experiment::SceneExperiment;
use crate::reading::MOST_RANDOM;
use crate::scene::SmpmScene;

/// A run as a function of the number of its random input.
type Sample<'a> = Box<dyn Fn(u64) -> Result<Vec<f64>, Error> + Sync + 'a>;

/// A grid with its reference run done; all samples take the steps of that run.
pub(super) struct Level<'a> {
    pub(super) cell: f64,
    pub(super) n_particles: usize,
    pub(super) n_steps: usize,
    /// The responses at the centre of the random inputs.
    pub(super) centre: Vec<f64>,
    run: Sample<'a>,
}

impl Level<'_> {
    /// Work of a run: particle updates.
    pub(super) fn work(&self) -> f64 {
        self.n_particles as f64 * self.n_steps as f64
    }

    /// The responses of a sample.
    pub(super) fn sample(&self, realisation: u64) -> Result<Vec<f64>, Failure> {
        let failed = |error| format!("on the grid of cell {}: {error}", self.cell).into();
        (self.run)(realisation).map_err(failed)
    }
}

/// Grids of a scene as the levels of an estimate, the coarsest first.
pub(super) struct Grids<'a> {
    pub(super) levels: Vec<Level<'a>>,
    pub(super) n_responses: usize,
}

impl Ladder for Grids<'_> {
    fn n_levels(&self) -> usize {
        self.levels.len()
    }

    fn n_responses(&self) -> usize {
        self.n_responses
    }

    fn cost(&self, level: usize) -> f64 {
        self.levels[level].work()
    }

    fn nests_by_construction(&self) -> bool {
        true
    }

    fn sample(
        &self,
        pair: Pair,
        realisation: u64,
        fine: &mut [f64],
        coarse: &mut [f64],
    ) -> Result<(), Failure> {
        fine.copy_from_slice(&self.levels[pair.fine].sample(realisation)?);
        if let Some(level) = pair.coarse {
            coarse.copy_from_slice(&self.levels[level].sample(realisation)?);
        }
        Ok(())
    }
}

/// The plan of a scene for coarser grids: what it reads at gauges, they read at the same points.
pub(super) fn for_coarser_grids<const D: usize>(
    scene: &SmpmScene,
    experiment: &SceneExperiment<D>,
    plan: &Plan<D>,
) -> Result<Plan<D>, Error> {
    if scene.random_fields.is_empty() {
        let centre = inputs(scene)?.centre();
        plan.interpolated(&Experiment::simulation(experiment, &centre)?)
    } else {
        let centre = vec![0.0; experiment.n_coefficients()];
        plan.interpolated(&FieldExperiment::simulation(experiment, &centre)?)
    }
}

/// A scene on its grid; the same numbers give the same random inputs on every grid.
pub(super) fn on_grid<'a, const D: usize>(
    scene: &SmpmScene,
    experiment: &'a SceneExperiment<D>,
    plan: &Plan<D>,
    seed: u64,
    keep: Option<&'a dyn Keep>,
) -> Result<Level<'a>, Error> {
    let (n_steps, centre, run) = if scene.random_fields.is_empty() {
        of_parameters(scene, experiment, plan, seed, keep)?
    } else {
        of_fields(experiment, plan, seed, keep)?
    };
    let (cell, n_particles) = (scene.grid.cell, experiment.n_particles());
    Ok(Level { cell, n_particles, n_steps, centre, run })
}

/// Number of steps, responses at the centre, and runs.
type Begun<'a> = (usize, Vec<f64>, Sample<'a>);

fn of_fields<'a, const D: usize>(
    experiment: &'a SceneExperiment<D>,
    plan: &Plan<D>,
    seed: u64,
    keep: Option<&'a dyn Keep>,
) -> Result<Begun<'a>, Error> {
    let study = FieldStudy::new(experiment, plan.clone(), keep)?;
    let (n_steps, centre) = (study.schedule().n_steps(), study.centre().to_vec());
    Ok((n_steps, centre, Box::new(move |k| study.run(&study.coefficients(seed, k)))))
}

fn of_parameters<'a, const D: usize>(
    scene: &SmpmScene,
    experiment: &'a SceneExperiment<D>,
    plan: &Plan<D>,
    seed: u64,
    keep: Option<&'a dyn Keep>,
) -> Result<Begun<'a>, Error> {
    let inputs = inputs(scene)?;
    let study = match keep {
        Some(keep) => Study::kept_by(experiment, inputs, plan.clone(), keep)?,
        None => Study::new(experiment, inputs, plan.clone())?,
    };
    let judge = MonteCarlo { seed, n_samples: 0 };
    let (n_steps, centre) = (study.schedule().n_steps(), study.centre().to_vec());
    Ok((n_steps, centre, Box::new(move |k| study.run(&judge.normals(k)))))
}

fn inputs(scene: &SmpmScene) -> Result<RandomVector<MOST_RANDOM>, Error> {
    // The check of the scene has built them.
    scene.inputs().map_err(|_| Error::EmptyPlan { what: "parameters" })
}
