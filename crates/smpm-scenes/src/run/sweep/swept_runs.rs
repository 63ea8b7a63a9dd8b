//! Runs of a sweep, in rounds, kept in the checkpoint.

use perturbation_moments::MonteCarlo;
use rayon::prelude::*;
use scene_runs::checkpoint::Checkpoint;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Inputs, Pace, Run, RunError};
use serde::{Deserialize, Serialize};
use smpm::uncertainty::Experiment;
use smpm::{Error, Plan, Quantity};
use uq_estimators::Trial;

use crate::experiment::SceneExperiment;
use crate::run::solve_error::SolveError;
use crate::scene::SmpmScene;
use crate::sweep_scene::SweepScene;

/// Name of the runs in a checkpoint.
const RUNS: &str = "runs of the sweep";
/// Keys that do not affect a run.
const ASIDE: [&str; 5] =
    ["/title", "/method/monte_carlo/samples", "/sweep/at", "/sweep/band", "/sweep/event/name"];

/// A run of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct SweptRun {
    /// Value of the number.
    pub(super) value: f64,
    /// Number of its sample of the random parameters; none at the centre.
    pub(super) sample: Option<u64>,
    /// The deciding quantity at the time before the last, if there is one, and at the last.
    pub(super) outcome: Option<[f64; 2]>,
    pub(super) n_steps: usize,
    /// Why the run failed.
    pub(super) failure: Option<String>,
}

impl SweptRun {
    /// Whether the event occurred; it has not where the run failed.
    pub(super) fn is_event(&self, sweep: &SweepScene) -> bool {
        self.outcome.is_some_and(|[_, last]| sweep.event.occurs(last))
    }
}

impl SweepScene {
    /// A value in parts of the range.
    pub(super) fn level(&self, value: f64) -> f64 {
        (value - self.from) / (self.to - self.from)
    }

    /// The value at a part of the range.
    pub(super) fn value(&self, level: f64) -> f64 {
        self.from + (self.to - self.from) * level
    }
}

/// Content of a checkpoint.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Kept {
    runs: Vec<SweptRun>,
    /// CPU time of all processes so far (s).
    cpu_seconds: f64,
}

/// A scene as a function of its swept number and the sample of its random parameters.
struct SweptModel<'a, const D: usize> {
    experiment: SceneExperiment<D>,
    plan: Plan<D>,
    /// Places of the deciding quantity at the time before the last and at the last among the responses.
    decisive: [usize; 2],
    seed: u64,
    number: &'a str,
}

impl<const D: usize> SweptModel<'_, D> {
    /// A run at a value; an error at the centre of the parameters, a failed run with a sample.
    fn run(&self, value: f64, sample: Option<u64>) -> Result<SweptRun, SolveError> {
        let varied = self.experiment.at_numbers(&[(self.number, value)])?;
        let inputs = varied.inputs();
        let mut normals = vec![0.0; inputs.n_normals()];
        if let Some(sample) = sample {
            MonteCarlo { seed: self.seed, n_samples: 0 }.fill_normals(sample, &mut normals);
        }
        let record = varied
            .simulation::<f64>(&inputs.point(&normals))
            .and_then(|mut simulation| simulation.record(&self.plan));
        let run = SweptRun { value, sample, outcome: None, n_steps: 0, failure: None };
        match record {
            Ok(record) => {
                let outcome = Some(self.decisive.map(|place| record.values[place]));
                Ok(SweptRun { outcome, n_steps: record.schedule.n_steps(), ..run })
            }
            Err(error) if sample.is_some() => {
                Ok(SweptRun { failure: Some(error.to_string()), ..run })
            }
            Err(error) => {
                let reason =
                    format!("the run at {value} and the centre of the parameters: {error}");
                Err(Error::InputsRefused { reason }.into())
            }
        }
    }
}

/// The runs of a sweep.
pub(super) struct SweptRuns<'a, const D: usize> {
    sweep: &'a SweepScene,
    model: SweptModel<'a, D>,
    /// Most runs with random parameters.
    most: u64,
    run: &'a Run<'a>,
    checkpoint: &'a Checkpoint,
    pace: Pace<'a>,
    clock: CpuClock,
    /// Runs of earlier processes, by order.
    known: Kept,
    all: Vec<SweptRun>,
}

impl<'a, const D: usize> SweptRuns<'a, D> {
    /// No run yet, except for those of an interrupted sweep.
    pub(super) fn new(
        scene: &'a SmpmScene,
        sweep: &'a SweepScene,
        run: &'a Run<'a>,
    ) -> Result<Self, SolveError> {
        let (experiment, plan) = (SceneExperiment::new(scene)?, scene.plan::<D>()?);
        let gauge = plan.gauges.iter().position(|gauge| gauge.name == sweep.event.gauge);
        let is_it = |quantity: &Quantity| quantity.to_string() == sweep.event.quantity;
        let quantity = plan.quantities.iter().position(is_it);
        let (gauge, quantity) = (gauge.unwrap_or_default(), quantity.unwrap_or_default());
        let last = plan.windows.len().saturating_sub(1);
        let decisive = [last.saturating_sub(1), last].map(|w| plan.index(gauge, quantity, w));
        let design = scene.design();
        let seed = design.map(|design| design.seed());
        let most = design.map_or(Ok(0), |design| design.n_runs())?;
        let number = &sweep.number;
        let checkpoint = run.checkpoint(&Inputs { scene, seed, files: &scene.files() }, &ASIDE)?;
        let known = checkpoint.part::<Kept>(RUNS).map_err(RunError::from)?.unwrap_or_default();
        Ok(Self {
            sweep,
            model: SweptModel {
                experiment,
                plan,
                decisive,
                seed: seed.unwrap_or_default(),
                number,
            },
            most,
            run,
            checkpoint,
            pace: run.pace("runs of the sweep"),
            clock: CpuClock::start(),
            known,
            all: Vec::new(),
        })
    }

    /// All runs so far, in order.
    pub(super) fn all(&self) -> &[SweptRun] {
        &self.all
    }

    /// Number of runs with random parameters.
    pub(super) fn n_sampled(&self) -> usize {
        self.all.iter().filter(|it| it.sample.is_some()).count()
    }

    pub(super) fn n_particles(&self) -> usize {
        self.model.experiment.n_particles()
    }

    /// CPU time of all processes so far (s).
    pub(super) fn cpu_seconds(&self) -> f64 {
        self.known.cpu_seconds + self.clock.seconds()
    }

    /// Outcomes of runs that have not failed, by level.
    pub(super) fn trials(&self, is_asked: impl Fn(&SweptRun) -> bool) -> Vec<Trial> {
        let counts = |it: &&SweptRun| it.outcome.is_some() && is_asked(it);
        let trial = |it: &SweptRun| Trial {
            level: self.sweep.level(it.value),
            is_event: it.is_event(self.sweep),
        };
        self.all.iter().filter(counts).map(trial).collect()
    }

    /// Runs at levels, each with a sample of the random parameters or at their centre; those of an interrupted sweep are kept.
    ///
    /// # Errors
    /// Those of a run at the centre; [`RunError`] where a run would take too long, or could not be kept.
    pub(super) fn round(
        &mut self,
        asked: &[(f64, Option<u64>)],
    ) -> Result<Vec<SweptRun>, SolveError> {
        let first = self.all.len();
        let (known, model, sweep) = (&self.known.runs, &self.model, self.sweep);
        let one = |(k, &(level, sample)): (usize, &(f64, Option<u64>))| {
            let value = sweep.value(level);
            let is_same =
                |it: &&SweptRun| it.value.to_bits() == value.to_bits() && it.sample == sample;
            match known.get(first + k).filter(is_same) {
                Some(known) => Ok(known.clone()),
                None => model.run(value, sample),
            }
        };
        let done = asked.par_iter().enumerate().map(one).collect::<Result<Vec<_>, SolveError>>()?;
        self.all.extend(done.iter().cloned());
        let (n, most) = (self.n_sampled() as u64, self.most.max(1));
        self.run.progress.at((n, most), || self.words());
        let allowed = self.pace.at(n as f64 / most as f64);
        if allowed.is_err() || self.checkpoint.is_due() {
            let kept = Kept { runs: self.all.clone(), cpu_seconds: self.cpu_seconds() };
            self.checkpoint.keep(RUNS, &kept).map_err(RunError::from)?;
        }
        allowed.map_err(RunError::from)?;
        Ok(done)
    }

    /// How many runs have the event.
    fn words(&self) -> String {
        let n = self.all.iter().filter(|it| it.is_event(self.sweep)).count();
        format!("{n} of {} {}", self.all.len(), self.sweep.event.name)
    }
}

/// Samples by value of the number, for a table.
pub(super) fn in_order(runs: &[SweptRun]) -> Vec<&SweptRun> {
    let mut runs: Vec<&SweptRun> = runs.iter().collect();
    runs.sort_by(|a, b| a.value.total_cmp(&b.value));
    runs
}
