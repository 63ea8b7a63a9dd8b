//! Runs a scene of a building: first-passage probabilities of its drifts, each with its error.

mod ladder;

use std::path::PathBuf;

use random_vibration::{
    FreePassages, GuidedConfig, GuidedPaths, PairwiseRule, PassageQuestion, SubsetConfig,
    TailError, subset_passage,
};
use result_figures::{Drawing, Line, Scale, TimeSeries, Words};
use scene_runs::answers::Unknown;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Completed, Computed, Inputs, Output, Run, RunError, SceneKind};
use scene_runs::machine::Machine;
use scene_runs::models::edit;
use scene_runs::result_file::ResultFile;
use scene_runs::scene::SceneFile;
use sde_integrators::Error;
use vibrating_systems::ShearBuilding;

use super::method_scene::BuildingMethod;
use super::scene::PassageScene;
use crate::path_blocks::path_blocks;
use crate::run::observed::Observed;
use crate::run::record::{Content, Probability, Quantity, Series, WorkRecord};
use crate::run::{answers, findings};
use crate::sources::{AU_BECK_2001, GIRSANOV_1960, MACKE_2003};

/// Its line in a table of kinds.
pub const KIND: SceneKind = SceneKind {
    solver: "random-vibration",
    schema: || schemars::schema_for!(PassageScene),
    check: |file| file.parse::<PassageScene>().map(drop),
    run,
    ladder: ladder::ladder,
    ingredients: |scene| edit::of(scene, ladder::ingredients),
};

/// Share of the paths without a guide.
const UNGUIDED: f64 = 0.05;
/// Paths for each pilot path, and the least number of pilot paths.
const PILOTS: (u64, u64) = (40, 200);
/// Steps of the linearisation per shortest period.
const STEPS_OF_GUIDE: f64 = 10.0;
/// Deviation of the drift that the linearisation of a yielding building leaves out, over that of the drift.
const UNMODELLED: f64 = 0.25;
/// Times per fundamental period at which the feedback of a guide is computed.
const FEEDBACKS: f64 = 30.0;

/// Why the page shows no field.
const NO_FIELD: &str =
    "This solver estimates probabilities from paths; it has no field over time to show.";

fn run(file: &SceneFile, run: &Run<'_>) -> Result<Completed, RunError> {
    let (mut scene, building) = run.build::<PassageScene>(file)?;
    let seed = Some(*scene.method.seed());
    let scene = &scene;
    let mut found = Passages::new(scene, &building);
    if let Some(elsewhere) = found.solve(run, &Inputs { scene, seed, files: &[] })? {
        return Ok(Completed::Elsewhere(elsewhere));
    }
    for Unknown { what, reason } in &found.unknown {
        run.progress.stage(&format!("unknown: {what}: {reason}"));
    }
    let quantities = found.series();
    let Passages { path_steps, cpu_seconds, unknown, .. } = found;
    let work = WorkRecord { path_steps, cpu_seconds, ..WorkRecord::default() };
    let answers = answers::answers(&quantities, &work);
    Completed::here(run, answers, || {
        let drawings = drawing(scene, &quantities)?.into_iter().collect();
        let content = Content { seed, work, stopped: None, unknown, quantities };
        let sources: &[_] = match scene.method {
            BuildingMethod::GuidedPaths { .. } => &[GIRSANOV_1960, MACKE_2003],
            BuildingMethod::MonteCarlo { .. } => &[],
            BuildingMethod::SubsetSimulation { .. } => &[AU_BECK_2001],
        };
        let mut report = findings::report(&content, &scene.method, sources);
        report.absent.push(NO_FIELD.to_owned());
        let result = ResultFile::new("run-result/1", scene, &content)?;
        Ok(Output { result, files: Vec::new(), drawings, motions: Vec::new(), report })
    })
}

/// First passages of a scene.
struct Passages<'a> {
    scene: &'a PassageScene,
    building: &'a ShearBuilding,
    /// Per threshold.
    values: Vec<Vec<Observed>>,
    unknown: Vec<Unknown>,
    path_steps: Option<u64>,
    cpu_seconds: f64,
}

impl<'a> Passages<'a> {
    fn new(scene: &'a PassageScene, building: &'a ShearBuilding) -> Self {
        let values = vec![Vec::new(); scene.thresholds.len()];
        let (unknown, path_steps, cpu_seconds) = (Vec::new(), None, 0.0);
        Self { scene, building, values, unknown, path_steps, cpu_seconds }
    }

    /// Estimates all probabilities by the method of the scene; returns the files of a shard, if this is one.
    fn solve(
        &mut self,
        run: &Run<'_>,
        inputs: &Inputs<'_, PassageScene>,
    ) -> Result<Option<Vec<PathBuf>>, RunError> {
        let Self { scene, building, .. } = *self;
        let (times, each) = (scene.times.list(), scene.steps_per_time());
        let n_steps: Vec<usize> = (1..=times.len()).map(|k| k * each).collect();
        let Some((&until, &all)) = times.last().zip(n_steps.last()) else { return Ok(None) };
        let (span, responses) = ((until, all), scene.responses(building));
        let (responses, thresholds) = (&responses[..], &scene.thresholds[..]);
        let question = PassageQuestion { responses, thresholds, n_steps: &n_steps };
        match scene.method {
            BuildingMethod::GuidedPaths { .. } => self.guided((run, inputs), &question, span),
            BuildingMethod::MonteCarlo { .. } => self.free((run, inputs), &question, span),
            BuildingMethod::SubsetSimulation { samples, correlation, runs, seed, .. } => {
                run.no_shards()?;
                // A method without a checkpoint still refuses to start over another run.
                run.checkpoint(inputs, &["/title"])?;
                run.progress.stage("subset simulation");
                let clock = CpuClock::start();
                let config = SubsetConfig { n_samples: samples, correlation, n_runs: runs };
                self.subset(run, &question, (&times, &config, seed))?;
                self.cpu_seconds = clock.seconds();
                Ok(None)
            }
        }
    }

    /// Guided paths, their blocks in any processes; the files of a shard, if this is one.
    fn guided(
        &mut self,
        (run, inputs): (&Run<'_>, &Inputs<'_, PassageScene>),
        question: &PassageQuestion<'_>,
        (until, n_steps): (f64, usize),
    ) -> Result<Option<Vec<PathBuf>>, RunError> {
        let BuildingMethod::GuidedPaths { samples, seed, .. } = self.scene.method else {
            return Ok(None);
        };
        run.progress.stage("guided paths");
        let clock = CpuClock::start();
        let (part, least) = PILOTS;
        let n_pilots = (samples / part).max(least);
        let config = GuidedConfig { n_paths: samples, n_pilots, unguided: UNGUIDED, seed };
        let rule = guide_rule(self.building, until / n_steps as f64);
        let paths = GuidedPaths::from_rest(self.building, (until, n_steps), &rule)
            .map_err(RunError::solver)?;
        let study = paths.passage_study(question, &config).map_err(RunError::solver)?;
        self.cpu_seconds = clock.seconds();
        let compute = |blocks| study.blocks(blocks);
        let blocks = match path_blocks(run, inputs, study.n_blocks(), &compute)? {
            Computed::Here(blocks) => blocks,
            Computed::Elsewhere(files) => return Ok(Some(files)),
        };
        self.path_steps = Some(study.path_steps());
        self.cpu_seconds += blocks.cpu_seconds;
        let rows = study.estimates(&blocks.list).map_err(RunError::solver)?;
        for (t, row) in self.scene.times.list().into_iter().zip(rows) {
            for (k, found) in row.into_iter().enumerate() {
                self.push((k, t), found.map(|found| Observed::of_guided(t, &found)))?;
            }
        }
        Ok(None)
    }

    /// Free paths, their blocks in any processes; the files of a shard, if this is one.
    fn free(
        &mut self,
        (run, inputs): (&Run<'_>, &Inputs<'_, PassageScene>),
        question: &PassageQuestion<'_>,
        span: (f64, usize),
    ) -> Result<Option<Vec<PathBuf>>, RunError> {
        let BuildingMethod::MonteCarlo { paths: n_paths, seed, .. } = self.scene.method else {
            return Ok(None);
        };
        run.progress.stage("Monte Carlo");
        let paths = FreePassages::new(self.building, span, question, (n_paths, seed))
            .map_err(RunError::solver)?;
        let compute = |blocks| paths.blocks(blocks);
        let blocks = match path_blocks(run, inputs, paths.n_blocks(), &compute)? {
            Computed::Here(blocks) => blocks,
            Computed::Elsewhere(files) => return Ok(Some(files)),
        };
        self.path_steps = Some(paths.path_steps());
        self.cpu_seconds = blocks.cpu_seconds;
        let rows = paths.estimates(&blocks.list).map_err(RunError::solver)?;
        for (t, row) in self.scene.times.list().into_iter().zip(rows) {
            for (k, estimate) in row.iter().enumerate() {
                self.push((k, t), Ok(Observed::of_estimate(t, estimate)))?;
            }
        }
        Ok(None)
    }

    /// Subset simulation of each time and threshold.
    fn subset(
        &mut self,
        run: &Run<'_>,
        question: &PassageQuestion<'_>,
        (times, config, seed): (&[f64], &SubsetConfig, u64),
    ) -> Result<(), RunError> {
        let PassageQuestion { responses, thresholds, n_steps } = *question;
        for (row, (&t, &steps)) in times.iter().zip(n_steps).enumerate() {
            for (k, &threshold) in thresholds.iter().enumerate() {
                let (building, span, how) = (self.building, (t, steps), (config, seed));
                let found = subset_passage(building, responses, threshold, span, how);
                self.push((k, t), found.map(|e| Observed::of_estimate(t, &e)))?;
            }
            let done = (row as u64 + 1, times.len() as u64);
            run.progress.at(done, || format!("t = {t:.4}"));
        }
        Ok(())
    }

    /// Adds a probability, or the reason why it is unknown.
    fn push(
        &mut self,
        (k, t): (usize, f64),
        found: Result<Observed, TailError>,
    ) -> Result<(), RunError> {
        match found {
            Ok(observed) => self.values[k].push(observed),
            Err(
                error @ (TailError::Untrusted { .. }
                | TailError::Sampling(Error::TooManyLevels { .. })),
            ) => self.unknown.push(Unknown {
                what: format!("first-passage/{} at t = {t}", self.scene.thresholds[k]),
                reason: error.to_string(),
            }),
            Err(error) => return Err(RunError::solver(error)),
        }
        Ok(())
    }

    /// The probabilities over time, threshold by threshold.
    fn series(&mut self) -> Vec<Series> {
        let demand = self.scene.response.storey.map_or_else(
            || "largest drift of all storeys".to_owned(),
            |storey| format!("largest drift of storey {storey}"),
        );
        let of_threshold = |(&threshold, values): (&f64, &mut Vec<Observed>)| Series {
            of: Quantity::Probability { by: Probability::FirstPassage, threshold },
            quantity: format!("P({demand} > {threshold})"),
            unit: String::new(),
            values: std::mem::take(values),
        };
        let all = self.scene.thresholds.iter().zip(&mut self.values).map(of_threshold);
        all.filter(|series| !series.values.is_empty()).collect()
    }
}

/// How the guides are linearised and held.
fn guide_rule(building: &ShearBuilding, dt: f64) -> PairwiseRule {
    let fundamental = building.natural_frequencies().first().copied().unwrap_or(f64::MIN_POSITIVE);
    let between = std::f64::consts::TAU / fundamental / FEEDBACKS;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of steps, and a cast saturates"
    )]
    let hold = ((between / dt).floor() as usize).max(1);
    let unmodelled = if building.is_hysteretic() { UNMODELLED } else { 0.0 };
    PairwiseRule { step: building.shortest_period() / STEPS_OF_GUIDE, hold, unmodelled }
}

/// Chart of the probabilities over time; none for one time.
fn drawing(scene: &PassageScene, quantities: &[Series]) -> Result<Option<Drawing>, RunError> {
    let line = |series: &Series| Line {
        name: series.quantity.clone(),
        points: series.values.iter().map(|observed| (observed.t, observed.known())).collect(),
    };
    let lines: Vec<Line> = quantities.iter().map(line).collect();
    let drawn = |line: &Line| line.points.iter().filter(|(_, value)| value.is_some()).count() > 1;
    if !lines.iter().any(drawn) {
        return Ok(None);
    }
    let words = Words {
        title: "Probability of first passage over time".into(),
        subtitle: scene.title.clone(),
        x_label: "time t (s)".into(),
        y_label: "P(passage up to t)".into(),
        caption: vec![
            "Values that are smaller than their error are left out.".to_owned(),
            Machine::read().caption(),
        ],
    };
    let (bands, references) = (Vec::new(), Vec::new());
    let chart = TimeSeries { words, scale: Scale::Log, lines, bands, references };
    Ok(Some(Drawing::time_series("first-passage", &chart).map_err(RunError::solver)?))
}
