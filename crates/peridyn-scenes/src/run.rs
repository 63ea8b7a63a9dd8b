//! Runs a crack scene: distributions of path, length, exit and load, each with its error.

mod answers;
mod fields;
mod findings;
mod growth;
mod ingredients;
mod ladder;
mod motion;
mod pictures;
mod record;

use peridyn_sde::statistics::{Bootstrap, CrackEnsemble};
use peridyn_sde::{CrackRun, HaltedRun};
use result_figures::number::with_uncertainty;
use scene_runs::checkpoint::{Checkpoint, CheckpointError};
use scene_runs::clock::CpuClock;
use scene_runs::interrupt;
use scene_runs::kind::{Completed, Computed, Cut, Inputs, Output, Run, RunError, SceneKind};
use scene_runs::models::edit;
use scene_runs::result_file::ResultFile;
use scene_runs::scene::{NamedFile, Objection, SceneFile};
use sde_integrators::{Accumulator, Noise};

pub(crate) use self::pictures::rank;
pub(crate) use self::record::Quantile;
use self::record::{Content, Record, WorkRecord};
use crate::points::Cloud;
use crate::progress::CrackProgress;
use crate::scene::{CrackScene, EnsembleScene};
use crate::scene_problem::CrackProblem;

/// Its line in a table of kinds.
pub const KIND: SceneKind = SceneKind {
    solver: "peridyn-sde",
    schema: || schemars::schema_for!(CrackScene),
    check: |file| file.parse::<CrackScene>().map(drop),
    run,
    ladder: ladder::ladder,
    ingredients: |scene| edit::of(scene, ingredients::ingredients),
};

/// Name of the finished realisations in a checkpoint.
const ENDED: &str = "realisations";
/// Name of those after them, halted before their end.
const HALTED: &str = "halted realisations";

/// Name of how their forces are computed.
const FORCES: &str = "forces";

/// Keys that do not affect single realisations: their number, and the output.
const ASIDE: [&str; 3] = ["/title", "/ensemble/realisations", "/output/abscissae"];

/// The realisations of a checkpoint are not the first of those requested.
///
/// The contribution of one realisation to the damage map cannot be removed again.
#[derive(Debug, thiserror::Error)]
#[error(
    "the checkpoint holds {found} realisations from number {first} on; requested are {asked} from number {start} on: \
     use another folder"
)]
struct OthersKept {
    found: u64,
    first: u64,
    asked: u64,
    start: u64,
}

/// The realisations of a checkpoint were computed in another order of sums than those asked for.
#[derive(Debug, thiserror::Error)]
#[error(
    "the checkpoint holds realisations whose forces were computed by `{found}`, and so many realisations take `{asked}`: use \
     another folder"
)]
struct OtherForces {
    found: String,
    asked: &'static str,
}

/// More shards than realisations.
#[derive(Debug, thiserror::Error)]
#[error("there are more shards than the {realisations} realisations")]
struct TooManyShards {
    realisations: u64,
}

/// Realisations of a checkpoint, and their time (s).
type Ended = (CrackRun, f64);

fn run(file: &SceneFile, run: &Run<'_>) -> Result<Completed, RunError> {
    let (scene, ()) = run.build::<CrackScene>(file)?;
    let refused = |objection: Objection| file.object_to(&objection);
    let cloud = Cloud::of_body(&scene.body, file.folder()).map_err(refused)?;
    let files: Vec<NamedFile> = cloud.iter().map(|cloud| cloud.file().clone()).collect();
    let inputs = &Inputs { scene: &scene, seed: Some(scene.ensemble.seed), files: &files };
    // A file that is no shard of this scene is rejected before the body is built.
    let shards = run.shards::<Ended>(inputs)?;
    let problem = CrackProblem::new(&scene, cloud).map_err(refused)?;
    let EnsembleScene { realisations: n, .. } = scene.ensemble;
    // A block holds as many realisations as run side by side in a register.
    let blocks = Cut { n, unit: problem.n_side_by_side(&scene) };
    let block = |block: u64| {
        let clock = CpuClock::start();
        let ended = problem.run(&scene, blocks.range(block))?;
        Ok((ended, clock.seconds()))
    };
    let words = |parts: &mut dyn Iterator<Item = &Ended>| load_words(parts.map(|(run, _)| run));
    let here = || realisations(inputs, &problem, run);
    let computed = match shards {
        Some(shards) => Computed::Here(shards),
        None => run.parts(inputs, blocks.n_blocks(), &block, &words, here)?,
    };
    let (crack_run, cpu_seconds) = match computed {
        Computed::Here(parts) => joined(parts)?,
        Computed::Elsewhere(files) => return Ok(Completed::Elsewhere(files)),
    };
    found(&scene, &problem, (&crack_run, cpu_seconds), run)
}

/// Shards in order.
fn joined(shards: Vec<Ended>) -> Result<Ended, RunError> {
    for (shard, _) in &shards {
        let expected = shard.records.len();
        Run::require("realisations with loads", shard.loads.len(), expected)?;
        Run::require("realisations with broken bonds", shard.broken.len(), expected)?;
    }
    let mut shards = shards.into_iter();
    let Some((mut all, mut cpu_seconds)) = shards.next() else { return Err(RunError::NoShards) };
    for (shard, seconds) in shards {
        all.append(shard).map_err(RunError::solver)?;
        cpu_seconds += seconds;
    }
    Ok((all, cpu_seconds))
}

/// All requested realisations, including those of a checkpoint.
fn realisations(
    inputs: &Inputs<'_, CrackScene>,
    problem: &CrackProblem,
    run: &Run<'_>,
) -> Result<Ended, RunError> {
    let scene = inputs.scene;
    let checkpoint = run.checkpoint(inputs, &ASIDE)?;
    let range = run.range(scene.ensemble.realisations);
    let asked = range.end - range.start;
    if asked == 0 {
        return Err(RunError::solver(TooManyShards { realisations: scene.ensemble.realisations }));
    }
    let forces = problem.resolved.forces;
    match checkpoint.part::<String>(FORCES)?.filter(|found| found != forces) {
        Some(found) => return Err(RunError::solver(OtherForces { found, asked: forces })),
        None => checkpoint.put(FORCES, &forces)?,
    }
    run.progress.stage(&format!("{asked} realisations"));
    let (past, past_seconds) = checkpoint.part::<Ended>(ENDED)?.unzip();
    let halted = checkpoint.part::<Option<(HaltedRun, f64)>>(HALTED)?.flatten();
    let (halted, halted_seconds) = halted.unzip();
    if let Some(past) = &past {
        let (found, start) = (past.records.len() as u64, range.start);
        let first = past.records.first().map_or(start, |record| record.realisation);
        if found > asked || first != start {
            return Err(RunError::solver(OthersKept { found, first, asked, start }));
        }
    }
    let clock = CpuClock::start();
    let past_seconds = halted_seconds.or(past_seconds).unwrap_or(0.0);
    let seconds = || past_seconds + clock.seconds();
    let (past, pace) = (CrackProgress { run: past, halted }, run.pace("realisations"));
    pace.at(past.n_ended() as f64 / asked as f64)?;
    let goes_on = |part: Option<f64>| {
        !interrupt::is_requested() && part.is_none_or(|part| pace.at(part).is_ok())
    };
    let ended = problem.run_while(scene, range, past, &goes_on, |so_far| {
        let done = so_far.n_ended();
        run.progress.at((done, asked), || load_words(&so_far.run));
        let allowed = pace.at(done as f64 / asked as f64);
        let is_halted = so_far.halted.is_some() || allowed.is_err();
        if done == asked || is_halted || checkpoint.is_due() {
            keep(checkpoint, so_far, seconds())?;
        }
        allowed.map_err(RunError::from)
    })?;
    Ok((ended, seconds()))
}

fn keep(
    checkpoint: &Checkpoint,
    so_far: &CrackProgress,
    seconds: f64,
) -> Result<(), CheckpointError> {
    let halted = so_far.halted.as_ref().map(|halted| (halted, seconds));
    match &so_far.run {
        None => checkpoint.keep(HALTED, &halted),
        Some(run) => {
            checkpoint.put(HALTED, &halted)?;
            checkpoint.keep(ENDED, &(run, seconds))
        }
    }
}

/// Current estimate of the failure load with its standard error.
fn load_words<'a>(runs: impl IntoIterator<Item = &'a CrackRun>) -> String {
    let mut loads = Accumulator::default();
    let records = runs.into_iter().flat_map(|run| &run.records);
    for load in records.filter_map(|record| record.failure_load) {
        loads.push(load);
    }
    let Ok(load) = loads.estimate() else { return String::new() };
    format!("failure load {} N", with_uncertainty(Some(load.value), load.standard_error()))
}

/// What the realisations give.
fn found(
    scene: &CrackScene,
    problem: &CrackProblem,
    (crack_run, cpu_seconds): (&CrackRun, f64),
    run: &Run<'_>,
) -> Result<Completed, RunError> {
    let n_realisations = scene.ensemble.realisations;
    let ensemble = CrackEnsemble::new(n_realisations, crack_run.records.iter().cloned())
        .map_err(RunError::solver)?;
    let bootstrap = Bootstrap::new(Noise::new(scene.ensemble.seed));
    let record = Record::new(scene, problem, crack_run, &ensemble, &bootstrap)?;
    for unknown in &record.unknown {
        run.progress.stage(&format!("unknown: {}: {}", unknown.what, unknown.reason));
    }
    Ok(Completed::here(run, answers::answers(&record, cpu_seconds), || {
        let content = Content {
            files: &problem.files,
            resolved: &problem.resolved,
            seed: scene.ensemble.seed,
            work: WorkRecord::new(scene, &problem.resolved, cpu_seconds),
            record: &record,
        };
        let mut report = findings::report(scene, &content);
        let drawn = pictures::drawings(scene, problem, crack_run, &ensemble, &record, &bootstrap);
        let drawings = report.drawn("charts", drawn);
        let motions = report.drawn("cracks over time", motion::motions(scene, problem, crack_run));
        let files = fields::write(scene, problem, crack_run, run.folder())?;
        let result = ResultFile::new("crack-ensemble/1", scene, &content)?;
        Ok(Output { result, files, drawings, motions, report })
    }))
}
