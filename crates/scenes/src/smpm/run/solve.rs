//! Methods of a scene.

use std::collections::BTreeMap;
use std::path::PathBuf;

use figures::number::with_uncertainty;
use perturbation_moments::Jet;
use sde_integrators::Accumulator;
use smpm::uncertainty::{Design, FrozenForm, Sampled, Study};
use smpm::{Error, Plan, Simulation};

use super::fields::Fields;
use super::kept::KeptRuns;
use super::response::{Control, Response, Table};
use crate::checkpoint::{Checkpoint, CheckpointError};
use crate::clock::CpuClock;
use crate::kind::{Cut, Inputs, Part, Run, RunError};
use crate::smpm::experiment::SceneExperiment;
use crate::smpm::scene::{MethodScene, SmpmScene};

/// Half width of a central difference that no scene sets, in standard deviations.
pub(super) const DIFFERENCE: f64 = 0.1;

/// Result of a run.
#[derive(Debug)]
pub(super) enum Solved {
    /// The complete answer.
    Whole(Answer),
    /// The file of a shard.
    Shard(PathBuf),
    /// Another rank holds the result.
    Elsewhere,
}

/// Complete answer of a scene.
#[derive(Debug)]
pub(super) struct Answer {
    /// In the order of the plan.
    pub(super) responses: Vec<Response>,
    pub(super) n_steps: usize,
    pub(super) n_runs: u64,
    pub(super) cpu_seconds: f64,
    pub(super) failures: Vec<(u64, String)>,
}

/// Runs the method of a scene with the distribution of `N` parameters; those beyond the scene's are certain.
pub(super) fn solve<const D: usize, const N: usize>(
    scene: &SmpmScene,
    experiment: &SceneExperiment<D>,
    plan: &Plan<D>,
    fields: &mut Fields,
    run: &Run<'_>,
) -> Result<Solved, SolveError> {
    let kept = KeptRuns::new(checkpoint(scene, run)?);
    let solved = solve_kept::<D, N>(scene, experiment, plan, fields, run, &kept);
    // The study knows only that the checkpoint failed.
    kept.into_failure().map_or(solved, |failure| Err(SolveError::Run(failure.into())))
}

/// Checkpoint of a scene whose samples are neither merged nor distributed over ranks.
fn checkpoint<'a>(scene: &SmpmScene, run: &'a Run<'_>) -> Result<Option<&'a Checkpoint>, RunError> {
    if run.ranks().is_some() || matches!(run.part(), Part::Merged(_)) {
        return Ok(None);
    }
    let (seed, aside) = match scene.design() {
        Some(design) => (Some(design.seed()), ASIDE_OF_SAMPLES.as_slice()),
        None => (None, ASIDE.as_slice()),
    };
    run.checkpoint(&Inputs { scene, seed, files: &[] }, aside).map(Some)
}

/// Solves the scene with runs that resume from stored ones.
fn solve_kept<const D: usize, const N: usize>(
    scene: &SmpmScene,
    experiment: &SceneExperiment<D>,
    plan: &Plan<D>,
    fields: &mut Fields,
    run: &Run<'_>,
    kept: &KeptRuns<'_>,
) -> Result<Solved, SolveError> {
    // A file that is no shard of this scene is rejected before any run.
    let shards = shards(scene, plan, run)?;
    // The check of the scene has built these inputs with more certain parameters.
    let inputs = scene.inputs::<N>().map_err(|_| Error::EmptyPlan { what: "parameters" })?;
    run.progress.stage("reference run");
    let study = Study::<_, D, N>::kept_by(experiment, inputs, plan.clone(), kept)?;
    let table = Table { scene, plan, centre: study.centre() };
    let (mut failures, mut n_runs, mut seconds_elsewhere) = (Vec::new(), 1, 0.0);
    let differences = 2 * scene.random.len() as u64;
    let responses = if let Some(design) = scene.design() {
        let control = scene.method.has_taylor_control();
        n_runs += design.n_runs()? + if control { differences } else { 0 };
        run.progress.stage("samples");
        let sampled = match sampled(&study, design, scene, run, kept, shards)? {
            Samples::All(sampled, elsewhere) => {
                seconds_elsewhere = elsewhere;
                sampled
            }
            Samples::Shard(file) => return Ok(Solved::Shard(file)),
            Samples::Elsewhere => return Ok(Solved::Elsewhere),
        };
        let surrogates = if control {
            run.progress.stage("differences of whole runs, for the control variate");
            study.finite_difference(DIFFERENCE)?
        } else {
            Vec::new()
        };
        let polynomial = match scene.method {
            MethodScene::QuasiMonteCarlo { control: true, .. } => {
                Some(sampled.polynomial_control()?)
            }
            _ => None,
        };
        failures = sampled.failures.iter().map(|(id, e)| (*id, e.to_string())).collect();
        table.each(|i, response| {
            let control = match &polynomial {
                Some(polynomial) => Control::Polynomial(polynomial),
                None => surrogates.get(i).map_or(Control::None, Control::Taylor),
            };
            table.sampled(i, response, &sampled, control)
        })?
    } else {
        let (responses, more_runs) = expanded(&study, &table, fields, run)?;
        n_runs += more_runs;
        responses
    };
    let cpu_seconds = kept.cpu_seconds() + seconds_elsewhere;
    let n_steps = study.schedule().n_steps();
    Ok(Solved::Whole(Answer { responses, n_steps, n_runs, cpu_seconds, failures }))
}

/// Responses by a method without samples, and its number of runs besides the reference run.
fn expanded<const D: usize, const N: usize>(
    study: &Study<'_, SceneExperiment<D>, D, N>,
    table: &Table<'_, D>,
    fields: &mut Fields,
    run: &Run<'_>,
) -> Result<(Vec<Response>, u64), Error> {
    Ok(match table.scene.method {
        MethodScene::Deterministic
        | MethodScene::MonteCarlo { .. }
        | MethodScene::QuasiMonteCarlo { .. }
        | MethodScene::SobolIndices { .. } => {
            fields.of_numbers(study)?;
            (table.each(|_, response| Ok(response))?, 0)
        }
        MethodScene::Frozen { as_printed } => {
            run.progress.stage("local formulas");
            let form = if as_printed { FrozenForm::Printed } else { FrozenForm::Corrected };
            let moments = study.frozen(form)?;
            let of = |i: usize, response| match &moments[i] {
                Some(moments) => table.taylor(i, response, moments, None),
                None => Ok(response),
            };
            (table.each(of)?, 1)
        }
        MethodScene::Propagated => {
            run.progress.stage("run with derivatives");
            let propagated = study.propagated_seen(|time, run: &Simulation<Jet, D>| {
                fields.of_jets(time, run, table.scene.random.len());
            })?;
            fields.are_shown();
            let of = |i: usize, response| {
                let switch = Some(&propagated.switches[i]);
                table.taylor(i, response, &propagated.moments[i], switch)
            };
            (table.each(of)?, 1)
        }
        MethodScene::FiniteDifference { step } => {
            run.progress.stage("differences of whole runs");
            let moments = study.finite_difference(step)?;
            let of = |i: usize, response| table.taylor(i, response, &moments[i], None);
            (table.each(of)?, 2 * table.scene.random.len() as u64)
        }
        MethodScene::ForwardDifference { step } => {
            run.progress.stage("one-sided differences of whole runs");
            let moments = study.forward_difference(step)?;
            let of = |i: usize, response| table.taylor(i, response, &moments[i], None);
            (table.each(of)?, table.scene.random.len() as u64)
        }
        MethodScene::SigmaPoints => {
            run.progress.stage("sigma points");
            let points = study.sigma_points()?;
            let of = |i: usize, response: Response| {
                Ok(response.with_moments(points[i].mean(), points[i].variance()))
            };
            (table.each(of)?, 2 * table.scene.random.len() as u64)
        }
    })
}

/// Error of a scene.
#[derive(Debug)]
pub(super) enum SolveError {
    /// The solver rejected its input or stopped.
    Solver(Error),
    /// Error outside the solver.
    Run(RunError),
}

impl From<Error> for SolveError {
    fn from(error: Error) -> Self {
        Self::Solver(error)
    }
}

impl From<Error> for RunError {
    fn from(error: Error) -> Self {
        Self::solver(error)
    }
}

impl From<RunError> for SolveError {
    fn from(error: RunError) -> Self {
        Self::Run(error)
    }
}

/// Name of the samples in a checkpoint.
const SAMPLES: &str = "samples";
/// Keys that do not affect samples.
///
/// More points of a quasi-random design continue it.
const ASIDE_OF_SAMPLES: [&str; 5] = [
    "/title",
    "/levels",
    "/method/monte_carlo/samples",
    "/method/quasi_monte_carlo/points",
    "/method/sobol_indices/points",
];
/// Keys that do not affect a run up to the first differing time, which the stored state records.
const ASIDE: [&str; 3] = ["/title", "/levels", "/times"];
/// Samples per block of a rank.
const SAMPLES_OF_BLOCK: u64 = 4;
/// Samples per thread between two reports.
const SAMPLES_OF_THREAD: usize = 4;

/// Samples of all shards, if shard files are merged.
fn shards<const D: usize>(
    scene: &SmpmScene,
    plan: &Plan<D>,
    run: &Run<'_>,
) -> Result<Option<Responses>, RunError> {
    let (Part::Merged(files), Some(design)) = (run.part(), scene.design()) else {
        return Ok(None);
    };
    let inputs = &Inputs { scene, seed: Some(design.seed()), files: &[] };
    let shards: Vec<Responses> = run.read_shards(inputs, files)?;
    let samples: Responses = shards.into_iter().flatten().collect();
    for responses in samples.values() {
        Run::require("responses", responses.len(), plan.n_responses())?;
    }
    Ok(Some(samples))
}

/// Result of the requested samples.
enum Samples<const N: usize> {
    /// All samples, and their CPU time on other ranks or in earlier processes (s).
    All(Sampled<N>, f64),
    /// The file of a shard.
    Shard(PathBuf),
    /// Another rank holds them.
    Elsewhere,
}

/// All requested samples: computed, from a checkpoint, from shards, or from blocks of ranks.
fn sampled<const D: usize, const N: usize>(
    study: &Study<'_, SceneExperiment<D>, D, N>,
    design: Design,
    scene: &SmpmScene,
    run: &Run<'_>,
    kept: &KeptRuns<'_>,
    shards: Option<Responses>,
) -> Result<Samples<N>, RunError> {
    let inputs = &Inputs { scene, seed: Some(design.seed()), files: &[] };
    let each = (SAMPLES_OF_THREAD * rayon::current_num_threads()) as u64;
    let n_runs = design.n_runs()?;
    let range = run.range(n_runs);
    let joined = |known: Responses, seconds: f64| {
        let all = study
            .sampled_from(design, range.clone(), &known, each, |_, _| Ok::<(), RunError>(()))?;
        Ok(Samples::All(all, seconds))
    };
    if let Some(shards) = shards {
        return joined(shards, 0.0);
    }
    if let Some(ranks) = run.ranks() {
        let blocks = Cut { n: n_runs, unit: SAMPLES_OF_BLOCK };
        // The clock of this process counts its own blocks.
        let is_here = ranks.rank() == 0;
        let compute = |block: u64| {
            let (clock, none) = (CpuClock::start(), Responses::new());
            let look = |_: &Sampled<N>, _: u64| Ok::<(), RunError>(());
            let of_block = study.sampled_from(design, blocks.range(block), &none, each, look)?;
            let seconds = if is_here { 0.0 } else { clock.seconds() };
            Ok((of_block.responses(), seconds))
        };
        let words = |parts: &mut dyn Iterator<Item = &(Responses, f64)>| {
            words(study, parts.flat_map(|(responses, _)| responses.values()))
        };
        let Some(parts) = run.on_ranks(ranks, inputs, blocks.n_blocks(), &compute, &words)? else {
            return Ok(Samples::Elsewhere);
        };
        let seconds = parts.iter().map(|(_, seconds)| seconds).sum();
        return joined(parts.into_iter().flat_map(|(responses, _)| responses).collect(), seconds);
    }
    let checkpoint = match kept.checkpoint {
        Some(checkpoint) => checkpoint,
        None => run.checkpoint(inputs, &ASIDE_OF_SAMPLES)?,
    };
    let known: Responses = checkpoint.part(SAMPLES)?.unwrap_or_default();
    let n = range.end - range.start;
    let sampled = study.sampled_from(design, range.clone(), &known, each, |so_far, tried| {
        run.progress.at((tried, n), || words(study, so_far.responses().values()));
        if tried == n || checkpoint.is_due() {
            keep(checkpoint, &known, so_far.responses())?;
        }
        Ok::<(), RunError>(())
    })?;
    Ok(match run.part() {
        Part::Shard(place) => {
            Samples::Shard(run.write_shard(inputs, *place, &sampled.responses())?)
        }
        Part::Whole | Part::Merged(_) => Samples::All(sampled, 0.0),
    })
}

/// Stores new samples next to the known ones, which may be more than the scene now requests.
fn keep(
    checkpoint: &Checkpoint,
    known: &Responses,
    so_far: Responses,
) -> Result<(), CheckpointError> {
    if so_far.keys().all(|sample| known.contains_key(sample)) {
        return Ok(());
    }
    let mut all = known.clone();
    all.extend(so_far);
    checkpoint.keep(SAMPLES, &all)
}

/// Responses by sample number.
type Responses = BTreeMap<u64, Vec<f64>>;

/// Current mean of the last response, with its standard error.
fn words<'a, const D: usize, const N: usize>(
    study: &Study<'_, SceneExperiment<D>, D, N>,
    so_far: impl Iterator<Item = &'a Vec<f64>>,
) -> String {
    let plan = study.plan();
    let last = plan.n_responses().saturating_sub(1);
    let mut values = Accumulator::default();
    for value in so_far.filter_map(|responses| responses.get(last)) {
        values.push(*value);
    }
    let Ok(mean) = values.estimate() else { return String::new() };
    let (gauge, quantity, _) = plan.parts(last);
    let mean = with_uncertainty(Some(mean.value), mean.standard_error());
    format!("{} at {}: {mean}", plan.quantities[quantity], plan.gauges[gauge].name)
}
