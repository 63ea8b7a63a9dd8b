//! A scene on grids of doubling cells, as the levels of a multilevel estimate.

use smpm::uncertainty::{Experiment, Keep, Study};
use smpm::{Error, Plan};
use uq_estimators::{Failure, Ladder, Pair};

use crate::experiment::SceneExperiment;
use crate::scene::SmpmScene;

/// A run as a function of the number of its random input.
type Sample<'a> = Box<dyn Fn(u64) -> Result<Vec<f64>, Error> + Sync + 'a>;

/// A grid with its reference run done; all samples take the steps of that run.
pub(in crate::run) struct Level<'a> {
    pub(in crate::run) cell: f64,
    pub(in crate::run) n_particles: usize,
    pub(in crate::run) n_steps: usize,
    /// The responses at the centre of the random inputs.
    pub(in crate::run) centre: Vec<f64>,
    run: Sample<'a>,
}

impl Level<'_> {
    /// Work of a run: particle updates.
    pub(in crate::run) fn work(&self) -> f64 {
        self.n_particles as f64 * self.n_steps as f64
    }

    /// The responses of a sample.
    pub(in crate::run) fn sample(&self, realisation: u64) -> Result<Vec<f64>, Failure> {
        let failed = |error| format!("on the grid of cell {}: {error}", self.cell).into();
        (self.run)(realisation).map_err(failed)
    }
}

/// Grids of a scene as the levels of an estimate, the coarsest first.
pub(in crate::run) struct Grids<'a> {
    pub(in crate::run) levels: Vec<Level<'a>>,
    pub(in crate::run) n_responses: usize,
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
pub(in crate::run) fn for_coarser_grids<const D: usize>(
    experiment: &SceneExperiment<D>,
    plan: &Plan<D>,
) -> Result<Plan<D>, Error> {
    let inputs = experiment.inputs();
    let centre = inputs.point(&vec![0.0; inputs.n_normals()]);
    plan.interpolated(&experiment.simulation::<f64>(&centre)?)
}

/// A scene on its grid; the same numbers give the same random inputs on every grid.
pub(in crate::run) fn on_grid<'a, const D: usize>(
    scene: &SmpmScene,
    experiment: &'a SceneExperiment<D>,
    plan: &Plan<D>,
    seed: u64,
    keep: Option<&'a dyn Keep>,
) -> Result<Level<'a>, Error> {
    let (inputs, plan) = (experiment.inputs(), plan.clone());
    let study = match keep {
        Some(keep) => Study::kept_by(experiment, inputs, plan, keep)?,
        None => Study::new(experiment, inputs, plan)?,
    };
    Ok(Level {
        cell: scene.grid.cell,
        n_particles: experiment.n_particles(),
        n_steps: study.schedule().n_steps(),
        centre: study.centre().to_vec(),
        run: Box::new(move |realisation| study.run(&study.normals(seed, realisation))),
    })
}
