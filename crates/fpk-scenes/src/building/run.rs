//! Runs a scene of a building: first-passage probabilities of its drifts, each with its error.

mod ladder;

use random_vibration::{
    FreePassages, GuidedConfig, GuidedPaths, PairwiseRule, PassageQuestion, PathBlock,
    SubsetConfig, subset_passage,
};
use result_figures::{Drawing, Scale};
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Completed, Computed, Inputs, Run, RunError, SceneKind};
use scene_runs::models::edit;
use scene_runs::scene::SceneFile;
use vibrating_systems::ShearBuilding;

use super::method_scene::BuildingMethod;
use super::scene::PassageScene;
use super::step_bias;
use crate::run::charts;
use crate::run::observed::Observed;
use crate::run::outcome::{Outcome, Presentation};
use crate::run::probabilities::{Probabilities, UNGUIDED};
use crate::run::record::{Probability, Series};
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
    let seed = *scene.method.seed();
    let scene = &scene;
    let times = scene.times.list();
    let found = Probabilities::new(Probability::FirstPassage, &times, &scene.thresholds);
    let mut found = match solve(scene, &building, (run, seed), found)? {
        Computed::Here(found) => found,
        Computed::Elsewhere(files) => return Ok(Completed::Elsewhere(files)),
    };
    run.progress.stage("pairs of paths, for the bias of the steps");
    found.add_bias(&step_bias::of_passages(scene, &building, seed));
    let demand = scene.response.storey.map_or_else(
        || "largest drift of all storeys".to_owned(),
        |storey| format!("largest drift of storey {storey}"),
    );
    let sources: &[_] = match scene.method {
        BuildingMethod::GuidedPaths { .. } => &[GIRSANOV_1960, MACKE_2003],
        BuildingMethod::MonteCarlo { .. } => &[],
        BuildingMethod::SubsetSimulation { .. } => &[AU_BECK_2001],
    };
    let shown = Presentation { scene, method: &scene.method, sources, absent: Some(NO_FIELD) };
    let outcome = Outcome::from(found.content(&demand, seed));
    Ok(outcome.completed(run, &shown, |quantities| drawings(&scene.title, quantities)))
}

/// All first passages by the method of the scene.
fn solve<'a>(
    scene: &PassageScene,
    building: &ShearBuilding,
    (run, seed): (&Run<'_>, u64),
    mut found: Probabilities<'a>,
) -> Result<Computed<Probabilities<'a>>, RunError> {
    let inputs = &Inputs { scene, seed: Some(seed), files: &[] };
    let each = scene.steps_per_time();
    let n_steps: Vec<usize> = (1..=found.times.len()).map(|k| k * each).collect();
    let until = found.times.last().copied().unwrap_or_default();
    let span = (until, found.times.len() * each);
    let responses = &scene.responses(building)[..];
    let question = PassageQuestion { responses, thresholds: found.thresholds, n_steps: &n_steps };
    match scene.method {
        BuildingMethod::GuidedPaths { samples, .. } => {
            run.progress.stage("guided paths");
            let clock = CpuClock::start();
            let (part, least) = PILOTS;
            let n_pilots = (samples / part).max(least);
            let config = GuidedConfig { n_paths: samples, n_pilots, unguided: UNGUIDED, seed };
            let rule = guide_rule(building, until / span.1 as f64);
            let paths = GuidedPaths::from_rest(building, span, &rule).map_err(RunError::solver)?;
            let study = paths.passage_study(&question, &config).map_err(RunError::solver)?;
            found.guided((run, inputs), &study, clock.seconds())
        }
        BuildingMethod::MonteCarlo { paths, .. } => {
            run.progress.stage("Monte Carlo");
            let paths = FreePassages::new(building, span, &question, (paths, seed))
                .map_err(RunError::solver)?;
            found.work.path_steps = Some(paths.path_steps());
            let compute = |blocks| paths.blocks(blocks);
            let estimates = |blocks: &[PathBlock]| paths.estimates(blocks);
            let observed = |t, estimate| Ok(Observed::of_estimate(t, &estimate));
            found.by_blocks((run, inputs), (paths.n_blocks(), &compute), estimates, observed)
        }
        BuildingMethod::SubsetSimulation { samples, correlation, runs, .. } => {
            run.no_shards()?;
            // A method without a checkpoint still refuses to start over another run.
            run.checkpoint(inputs, &["/title"])?;
            run.progress.stage("subset simulation");
            let clock = CpuClock::start();
            let config = &SubsetConfig { n_samples: samples, correlation, n_runs: runs };
            for (row, (&t, &steps)) in found.times.iter().zip(&n_steps).enumerate() {
                for (k, &threshold) in found.thresholds.iter().enumerate() {
                    let (span, how) = ((t, steps), (config, seed));
                    let estimate = subset_passage(building, responses, threshold, span, how);
                    found.push((k, t), estimate.map(|it| Observed::of_estimate(t, &it)))?;
                }
                let done = (row as u64 + 1, n_steps.len() as u64);
                run.progress.at(done, || format!("t = {t:.4}"));
            }
            found.work.cpu_seconds = clock.seconds();
            Ok(Computed::Here(found))
        }
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
fn drawings(title: &str, quantities: &[Series]) -> Result<Vec<Drawing>, RunError> {
    let lines = charts::lines(quantities, Observed::known);
    if lines.iter().all(|line| charts::n_shown(line) < 2) {
        return Ok(Vec::new());
    }
    let words = ["Probability of first passage over time", title, "P(passage up to t)"];
    Ok(vec![charts::over_time("first-passage", words, (Scale::Log, lines))?])
}
