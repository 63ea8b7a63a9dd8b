//! Runs a density scene: several resolutions for the error, or Monte Carlo with its standard error.

mod ingredients;
mod ladder;
mod linearised;
mod on_grid;
pub(crate) mod outcome;
pub(crate) mod probabilities;
mod resolution_error;
mod resolutions;
mod sampled;
mod shown;
pub(crate) mod step_bias;
mod step_runs;
mod tails;
#[cfg(test)]
mod tests;

pub(crate) use self::shown::{answers, charts, findings, motion, observed, pictures, record};

use fpk_sph::{ConditionedSimulation, Config, Simulation};
use random_vibration::{GridConfig, SubsetConfig};
use result_figures::{Drawing, Scale};
use result_pages::Source;
use scene_runs::answers::Unknown;
use scene_runs::checkpoint::Checkpoint;
use scene_runs::interrupt;
use scene_runs::kind::{Completed, Computed, Inputs, Run, RunError, SceneKind};
use scene_runs::models::edit;
use scene_runs::scene::SceneFile;
use sde_integrators::{Additive, GaussianMixture, NoiseClass, Sde};
use serde::{Deserialize, Serialize};
use vibrating_systems::Filtered;

use crate::density::{
    self, DensityRun, DensitySimulation, Erased, ObservedRun, Reached, Requested, Row,
};
use crate::method_scene::MethodScene;
use crate::monte_carlo::Sampling;
use crate::paths::{Paths, PathsError};
use crate::scene::{FpkScene, OtherDimension};
use crate::sources::{
    AU_BECK_2001, CANOR_2013, GIRSANOV_1960, MACKE_2003, ROBERTS_1990, SCHARFETTER_1969,
};
use crate::system::{FilteredVisitor, System, Visitor};
use charts::lines;
use linearised::Linearised;
use observed::Observed;
use outcome::{Outcome, Presentation};
use pictures::{PictureData, Pictures};
use record::{
    Content, Quantity, Series, WorkRecord, best_probabilities, conditions_nonlinear,
    magnitude_name, progress_words, series,
};
use resolutions::Resolutions;
use sampled::Sampled;
use tails::{Estimator, TailsOf};

/// Its line in a table of kinds.
pub const KIND: SceneKind = SceneKind {
    solver: "fpk-sph",
    schema: || schemars::schema_for!(FpkScene),
    check: |file| file.parse::<FpkScene>().map(drop),
    run,
    ladder: ladder::ladder,
    ingredients: |scene| edit::of(scene, ingredients::ingredients),
};

fn run(file: &SceneFile, run: &Run<'_>) -> Result<Completed, RunError> {
    let (scene, system) = run.build::<FpkScene>(file)?;
    let outcome = match solve(&scene, &system, run)? {
        Computed::Here(outcome) => outcome,
        Computed::Elsewhere(files) => return Ok(Completed::Elsewhere(files)),
    };
    let shown = Presentation {
        scene: &scene,
        method: &scene.method,
        sources: sources(&scene.method),
        absent: scene.planes.is_none().then_some(motion::ABSENT),
    };
    Ok(outcome.completed(run, &shown, |quantities| drawings(&scene, &system, quantities)))
}

/// What to cite for a method.
fn sources(method: &MethodScene) -> &'static [Source] {
    match method {
        MethodScene::GuidedPaths { .. } => &[GIRSANOV_1960, MACKE_2003],
        MethodScene::SubsetSimulation { .. } => &[AU_BECK_2001],
        MethodScene::StatisticalLinearisation { .. } => &[ROBERTS_1990],
        MethodScene::ConservativeGrid { .. } => &[SCHARFETTER_1969],
        MethodScene::MonteCarlo { .. } => &[],
        _ => &[CANOR_2013],
    }
}

/// Solves the scene by its method.
fn solve(scene: &FpkScene, system: &System, run: &Run<'_>) -> Result<Computed<Outcome>, RunError> {
    if let MethodScene::MonteCarlo { paths, step, seed, .. } = scene.method {
        run.progress.stage("Monte Carlo");
        let sampling = Sampling { paths, step, seed };
        return Ok(system.visit(Sampled { scene, system, sampling, run })?.map(Outcome::from));
    }
    let inputs = Inputs { scene, seed: None, files: &[] };
    let alone = || {
        run.no_shards()?;
        // A method without a checkpoint still refuses to start over another run.
        run.checkpoint(&inputs, &["/title"])
    };
    match scene.method {
        MethodScene::ConservativeGrid { cells, reach, steps_per_period } => {
            alone()?;
            let period = system.reference_period();
            let config = GridConfig { cells, reach, period, steps_per_period };
            Ok(Computed::Here(on_grid::solve(scene, system, run, &config)?.into()))
        }
        MethodScene::StatisticalLinearisation { step } => {
            alone()?;
            run.progress.stage("statistical linearisation");
            Ok(Computed::Here(system.visit(Linearised { scene, system, run, step })?.into()))
        }
        MethodScene::GuidedPaths { samples, step, seed, .. } => {
            let how = Estimator::Guided { samples };
            Ok(system.visit(TailsOf { scene, system, run, step, seed, how })?.map(Outcome::from))
        }
        MethodScene::SubsetSimulation { samples, correlation, runs, step, seed, .. } => {
            let config = SubsetConfig { n_samples: samples, correlation, n_runs: runs };
            let how = Estimator::Subset { config };
            Ok(system.visit(TailsOf { scene, system, run, step, seed, how })?.map(Outcome::from))
        }
        _ => {
            run.no_shards()?;
            let checkpoint = run.checkpoint(&inputs, &["/title", "/times/until"])?;
            let solved = || Solved { scene, system, run, checkpoint };
            let conditioned = scene.method.conditions_filter();
            let outcome = conditioned.then(|| system.visit_filtered(solved())).flatten();
            outcome.unwrap_or_else(|| system.visit(solved())).map(Computed::Here)
        }
    }
}

/// Largest number of states for which exceedances are integrated over cells.
///
/// Beyond it each cell has thousands of parts.
const MOST_STATES_OF_CELLS: usize = 4;

/// Why nothing is integrated over cells, where that applies.
fn no_cells(method: &MethodScene, states: usize) -> Option<Unknown> {
    let reason = match method {
        MethodScene::FlowMapFit(_) => {
            (states > MOST_STATES_OF_CELLS).then(|| {
                format!(
                    "cells are integrated in {MOST_STATES_OF_CELLS} dimensions at most, and there are {states} states: \
                     read exceedance-log-interpolated"
                )
            })
        }
        _ => Some(
            "the method follows no flow map, which integrals over cells need: read exceedance-log-interpolated"
                .to_owned(),
        ),
    }?;
    Some(Unknown { what: "exceedance-cell and cell-mass".to_owned(), reason })
}

/// The error of the assumption by which the states of a filter are conditioned out, which a linear structure does not have.
fn assumed(scene: &FpkScene, system: &System) -> Option<Unknown> {
    conditions_nonlinear(scene, system).then(|| Unknown {
        what: "errors of moments and probabilities".to_owned(),
        reason: "one covariance of the filter is taken for all states, and no lattice shows the error of that: second moments were \
                 seen within 0.2 % for dampers and springs, 2.1 % for hysteresis; a tail of 1e-4 up to 10 % low"
            .to_owned(),
    })
}

/// A cloud that a cubic spring folds, on one lattice.
fn lost_tail(scene: &FpkScene) -> Option<Unknown> {
    let MethodScene::FlowMapFit(lattice) = &scene.method else { return None };
    let on_one = scene.method.conditions_filter() && lattice.fresh_lattices.is_none();
    (on_one && scene.system.shakes_cubic_spring()).then(|| Unknown {
        what: "how much of the tail is lost".to_owned(),
        reason: "a cubic spring folds the cloud within a few periods, and on one lattice the tail is lost without a sign: \
                 add `fresh_lattices` to the method"
            .to_owned(),
    })
}

impl From<PathsError> for RunError {
    fn from(error: PathsError) -> Self {
        Self::solver(error)
    }
}

/// The density solver at several resolutions.
struct Solved<'a> {
    scene: &'a FpkScene,
    system: &'a System,
    run: &'a Run<'a>,
    checkpoint: &'a Checkpoint,
}

/// Content of a checkpoint of a density run: its state and its results so far.
#[derive(Debug, Default, Serialize, Deserialize)]
struct SavedDensity {
    reached: Reached,
    seen: PictureData,
}

impl Solved<'_> {
    /// Resumes a run from a part of the checkpoint; returns the run and its pictures.
    fn density<S: Sde<D, M>, O: DensitySimulation<S, D, M>, const D: usize, const M: usize>(
        &self,
        part: &str,
        density: Density<'_, D, impl FnOnce() -> Result<O, fpk_sph::Error>>,
        mut pictures: Option<&mut Pictures<'_>>,
    ) -> Result<Result<DensityRun, fpk_sph::Error>, RunError> {
        let Density { start, asked, past } = density;
        let n_times = asked.times.len();
        let mut failure = None;
        let look = |standing: ObservedRun<'_, S, D, M>| {
            if let Some(pictures) = pictures.as_mut().filter(|_| !standing.is_halted) {
                pictures.look(&standing);
            }
            self.report_progress(standing.rows, n_times);
            let is_last = standing.is_halted || standing.rows.len() == n_times;
            if failure.is_none() && (is_last || self.checkpoint.is_due()) {
                let seen =
                    pictures.as_ref().map_or_else(PictureData::default, |p| p.seen().clone());
                let kept = standing.reached().map(|reached| SavedDensity { reached, seen });
                failure = match kept {
                    Ok(kept) => self.checkpoint.keep(part, &kept).err().map(RunError::from),
                    Err(error) => Some(RunError::solver(error)),
                };
            }
        };
        let pace = self.run.pace("density");
        let end = asked.times.last().copied().unwrap_or_default();
        let mut goes_on = |t: f64| !interrupt::is_requested() && pace.at(t / end).is_ok();
        let run = density::run_from(start, asked, past, look, &mut goes_on);
        failure.map_or_else(|| Ok(pace.allowed()?), Err)?;
        Ok(run)
    }

    /// Reports the first moment of the scene at the last time.
    fn report_progress(&self, rows: &[Row], n_times: usize) {
        let Some(row) = rows.last() else { return };
        let done = (rows.len() as u64, n_times as u64);
        let words = || progress_words(self.scene, self.system, row.t, &row.moments);
        self.run.progress.at(done, words);
    }
}

/// Inputs of a density run.
struct Density<'a, const D: usize, F> {
    start: F,
    asked: &'a Requested<D>,
    past: Reached,
}

impl Visitor for Solved<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        self.solved(system)
    }
}

impl FilteredVisitor for Solved<'_> {
    type Output = Result<Outcome, RunError>;

    /// The density of the structure, whose filter is conditioned out.
    fn visit<S, const DS: usize, const DF: usize, const D: usize>(
        self,
        system: &Filtered<S, DS, DF>,
    ) -> Self::Output
    where
        S: Sde<DS, 1, Noise = Additive>,
    {
        let law: GaussianMixture<D> = self.scene.initial_law(self.system)?;
        let structure = Erased(system.structure() as &dyn Sde<DS, 1, Noise = Additive>);
        let erased = Filtered::new(structure, *system.filter(), system.noise_window().clone());
        let erased = erased.map_err(RunError::solver)?;
        let period =
            self.system.structure_period().unwrap_or_else(|| self.system.reference_period());
        let period = self.scene.reference_period(period);
        let start = |config: &Config<DS>| ConditionedSimulation::new(&erased, &law, config);
        self.at_resolutions(period, deviations(&law), start)
    }
}

impl Solved<'_> {
    /// The density at several resolutions, compiled once for each dimension and class of noise.
    fn solved<N: NoiseClass, const D: usize, const M: usize>(
        self,
        system: &dyn Sde<D, M, Noise = N>,
    ) -> Result<Outcome, RunError> {
        let law: GaussianMixture<D> = self.scene.initial_law(self.system)?;
        let period = self.scene.reference_period(self.system.reference_period());
        let start = |config: &Config<D>| Simulation::new(Erased(system), &law, config);
        self.at_resolutions(period, deviations(&law), start)
    }

    /// The density of a simulation that `start` returns, at several resolutions.
    fn at_resolutions<S, O, const D: usize, const M: usize>(
        self,
        period: f64,
        deviations: [f64; D],
        start: impl Fn(&Config<D>) -> Result<O, fpk_sph::Error>,
    ) -> Result<Outcome, RunError>
    where
        S: Sde<D, M>,
        O: DensitySimulation<S, D, M>,
    {
        let Self { scene, system: named, run, .. } = self;
        let no_cells = no_cells(&scene.method, D);
        let mut asked = scene.requested::<D>(named, no_cells.is_none())?;
        let config = scene.method.density_config::<D>(period, 1.0);
        let interval;
        (interval, asked.kinks) = step_runs::Interval::of_scene(scene, config.as_ref(), period);
        let (asked, start) = (&asked, &start);
        let solve = |part: &str, attempt: &Attempt| {
            let whole = attempt.method.density_config::<D>(period, attempt.fineness);
            let whole = whole.ok_or_else(|| RunError::solver(OtherDimension { states: D }))?;
            let whole = step_runs::with_steps_of_interval(whole, interval);
            run.progress.stage(part);
            let kept: SavedDensity = self.checkpoint.part(part)?.unwrap_or_default();
            let seen = kept.seen.until(asked.times.last().copied().unwrap_or_default());
            let mut pictures = Pictures::new(scene, named.states(), &whole, run.folder(), seen);
            let density = Density { start: || start(&whole), asked, past: kept.reached };
            let fine = self.density(part, density, Some(&mut pictures))?;
            let fine = fine.map_err(RunError::solver)?;
            let is_of_flow_map = attempt.method.follows_flow_map();
            let fine = if is_of_flow_map { refused_if_violated(fine) } else { fine };
            Ok::<_, RunError>((fine, whole, pictures))
        };
        let mut attempt = Attempt { method: scene.method.clone(), fineness: 1.0 };
        let (mut fine, mut whole, mut pictures) = solve("density", &attempt)?;
        let (mut repeated, mut next) = (None, attempt.clone());
        while let Some(reason) = fine.stopped.as_ref().map(ToString::to_string) {
            let Some(other) = fine.stopped.as_ref().and_then(|error| next.after::<D>(error)) else {
                break;
            };
            let (run_of_other, of_other, pictures_of_other) = solve(&other.part(), &other)?;
            if run_of_other.rows.len() > fine.rows.len() || run_of_other.stopped.is_none() {
                repeated = Some(Unknown {
                    what: "the density on the lattice of the scene".to_owned(),
                    reason: format!("{reason}; what is shown is the run {}", other.words()),
                });
                (fine, whole, pictures) = (run_of_other, of_other, pictures_of_other);
                attempt = other.clone();
            }
            next = other;
        }
        let Attempt { method, fineness } = attempt;
        let config = |part: f64| method.density_config::<D>(period, fineness * part);
        run.progress.stage("density at coarser resolutions, for its error");
        let both = Resolutions::new(fine, (config, interval), |name, config| {
            let SavedDensity { reached, .. } = self.checkpoint.part(name)?.unwrap_or_default();
            let density = Density { start: || start(config), asked, past: reached };
            self.density(name, density, None)
        })?;
        let lacking =
            |powers: &[u32; D]| whole.lattice.moment_lacking(&deviations, powers.iter().sum());
        let beyond_reach: Vec<f64> = asked.powers.iter().map(lacking).collect();
        let quantities = series(&both, scene, named, &beyond_reach);
        let lost_tail = if repeated.is_none() { lost_tail(scene) } else { None };
        let parts = [
            no_cells,
            repeated,
            assumed(scene, named),
            lost_tail,
            both.unknown(),
            both.not_shown(),
        ];
        let unknown = parts.into_iter().flatten().collect();
        let fine = both.fine;
        let (planes, files) = pictures.finish()?;
        let work = WorkRecord {
            particles: Some(fine.n_particles),
            steps: Some(fine.work.steps),
            evaluations: Some(fine.work.evaluations),
            neighbour_visits: Some(fine.work.neighbour_visits),
            path_steps: None,
            cpu_seconds: fine.rows.last().map_or(0.0, |row| row.cpu_seconds),
        };
        let stopped = fine.stopped;
        let reason = stopped.as_ref().map(ToString::to_string);
        let content = Content { seed: None, work, stopped: reason, unknown, quantities };
        Ok(Outcome { content, stopped, planes, files })
    }
}

/// A method of moving particles on a lattice finer than that of the scene.
#[derive(Debug, Clone, PartialEq)]
struct Attempt {
    method: MethodScene,
    /// Particles along a length, relative to the scene.
    fineness: f64,
}

impl Attempt {
    /// What to try after an error: remeshing where the flow map folds, then twice as many particles in all where the lattice does
    /// not resolve the density. None from three states on, where a run would cost many times what the scene asks for.
    fn after<const D: usize>(&self, error: &fpk_sph::Error) -> Option<Self> {
        use fpk_sph::Error;
        let is_folded =
            matches!(error, Error::MomentsViolated { .. } | Error::TooMuchUnresolved { .. });
        if is_folded && let Some(method) = self.method.remeshed() {
            return Some(Self { method, ..*self });
        }
        let is_coarse = is_folded
            || matches!(
                error,
                Error::RemappingChangesMass { .. }
                    | Error::StepCollapsed { .. }
                    | Error::NoLatticeCell { .. }
            );
        let most = *MOST_FINENESS.get(D - 1)?;
        let fineness = 2.0_f64.powf(1.0 / D as f64) * self.fineness;
        let is_tried = self.method.follows_flow_map() && is_coarse && fineness < 1.01 * most;
        is_tried.then(|| Self { fineness, ..self.clone() })
    }

    fn words(&self) -> String {
        let finer = if self.fineness > 1.0 {
            format!(" on a lattice with {:.2} times the particles along a length", self.fineness)
        } else {
            String::new()
        };
        format!("with `fresh_lattices`{finer}")
    }

    fn part(&self) -> String {
        format!("density {}", self.words())
    }
}

/// Particles along a length of the finest lattice that is tried, relative to the scene, in one and in two states.
const MOST_FINENESS: [f64; 2] = [8.0, 2.0];

/// Largest relative error of standard deviations, by the moment equations, with which a run goes on: it is an estimate of first order.
const MOST_VIOLATION: f64 = 0.1;

/// Ends a run before the first time at which the particles violate the moment equations.
fn refused_if_violated(mut fine: DensityRun) -> DensityRun {
    let Some(first) = fine.rows.iter().position(|row| row.violation > MOST_VIOLATION) else {
        return fine;
    };
    let Row { t: time, violation: value, .. } = fine.rows[first];
    fine.rows.truncate(first);
    fine.stopped = Some(fpk_sph::Error::MomentsViolated { time, value, limit: MOST_VIOLATION });
    fine
}

/// Standard deviations of the first states.
fn deviations<const D: usize, const K: usize>(law: &GaussianMixture<D>) -> [f64; K] {
    let covariance = law.covariance();
    std::array::from_fn(|k| covariance[k][k].sqrt())
}

/// Charts of second moments and probabilities over time.
fn drawings(
    scene: &FpkScene,
    system: &System,
    quantities: &[Series],
) -> Result<Vec<Drawing>, RunError> {
    let is_second = |series: &&Series| matches!(&series.of, Quantity::Moment(powers) if powers.iter().sum::<u32>() == 2);
    let moments = lines(quantities.iter().filter(is_second), |observed| Some(observed.value));
    // The chart shows one estimator, the best that the method offers; the result contains all.
    let tails = lines(best_probabilities(quantities), Observed::known);
    let exceeds = format!("P({} > T)", magnitude_name(scene, system));
    let mut drawings = Vec::new();
    for (name, title, y_label, scale, mut lines) in [
        ("moments", "Second moments over time", "second moment", Scale::Linear, moments),
        ("exceedance", "Probability of exceedance over time", &exceeds, Scale::Log, tails),
    ] {
        // A logarithmic scale has no place for zero.
        let is_drawn = |value: f64| scale == Scale::Linear || value > 0.0;
        lines.retain(|line| line.points.iter().any(|(_, value)| value.is_some_and(is_drawn)));
        if !lines.is_empty() {
            let words = [title, &scene.title, y_label];
            drawings.push(charts::over_time(name, words, (scale, lines))?);
        }
    }
    Ok(drawings)
}
