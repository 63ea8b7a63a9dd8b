//! Runs a scene of bodies on a grid: mean and variance of every response, with trust indicators.

mod answers;
mod balance;
mod fields;
mod findings;
mod ingredients;
mod kept;
mod ladder;
mod levels;
mod record;
mod response;
mod samples;
mod shown;
mod solve;
mod solve_error;
mod sweep;

use result_figures::{Band, Drawing, Line, Scale, TimeSeries, Words};
use scene_runs::kind::{Completed, Output, Run, RunError, SceneKind};
use scene_runs::machine::Machine;
use scene_runs::models::edit;
use scene_runs::output::write_text;
use scene_runs::result_file::ResultFile;
use scene_runs::scene::{Objection, SceneFile};
use smpm::Plan;

use self::fields::Fields;
use self::record::{Content, Failure, FieldResult, GaugeResult, WorkRecord, by_gauge};
use self::response::{Response, Shares};
use self::solve::{Answer, Solved};
use self::solve_error::SolveError;
use crate::experiment::SceneExperiment;
use crate::method_scene::MethodScene;
use crate::scene::SmpmScene;

/// Its line in a table of kinds.
pub const KIND: SceneKind = SceneKind {
    solver: "smpm",
    schema: || schemars::schema_for!(SmpmScene),
    check: |file| file.parse::<SmpmScene>().map(drop),
    run,
    ladder: ladder::ladder,
    ingredients: |scene| edit::of(scene, ingredients::ingredients),
};

fn run(file: &SceneFile, run: &Run<'_>) -> Result<Completed, RunError> {
    let (scene, ()) = run.build::<SmpmScene>(file)?;
    match scene.method {
        MethodScene::Multilevel(_) => run.no_shards_of_a_plan()?,
        _ if scene.sweep.is_some() => run.no_shards_of_a_plan()?,
        _ if scene.design().is_none() => run.no_shards()?,
        _ => {}
    }
    match scene.dimension {
        1 => run_in::<1>(file, &scene, run),
        2 => run_in::<2>(file, &scene, run),
        _ => run_in::<3>(file, &scene, run),
    }
}

fn run_in<const D: usize>(
    file: &SceneFile,
    scene: &SmpmScene,
    run: &Run<'_>,
) -> Result<Completed, RunError> {
    let object = |objection: Objection| RunError::from(file.object_to(&objection));
    let experiment = SceneExperiment::<D>::new(scene).map_err(object)?;
    let plan = scene.plan::<D>().map_err(object)?;
    let mut notes = scene.rounded_sizes();
    notes.extend(scene.implausible().map_err(object)?);
    notes.extend(scene.unused_fields());
    notes.extend(scene.bonded_gaps::<D>().map_err(object)?);
    notes.extend(scene.sparse_particles());
    notes.extend(scene.levels_of_one_run());
    let print = |notes: &[String]| {
        for note in notes {
            run.progress.stage(&format!("note: {note}"));
        }
    };
    for (material, source) in scene.origins() {
        run.progress.stage(&format!("{material}: {source}"));
    }
    print(&notes);
    if let Some(sweep) = &scene.sweep {
        return sweep::solve::<D>(scene, sweep, notes, run).map_err(|error| match error {
            SolveError::Solver(error) => in_the_scene(file, scene, error),
            SolveError::Run(error) => error,
            SolveError::Scene(objection) => object(objection),
        });
    }
    let mut fields = Fields::new(scene, plan.stops(), run.folder());
    let answer = match &scene.method {
        MethodScene::Multilevel(method) => {
            let of_scene = (&experiment, &plan);
            levels::multilevel::solve(scene, method, of_scene, &mut fields, run)
        }
        _ => solve::solve(scene, &experiment, &plan, &mut fields, run),
    };
    let answer = match answer {
        Ok(Solved::Whole(answer)) => answer,
        Ok(Solved::Shard(file)) => return Ok(Completed::Elsewhere(vec![file])),
        Ok(Solved::Elsewhere) => return Ok(Completed::Elsewhere(Vec::new())),
        Err(SolveError::Solver(error)) => return Err(in_the_scene(file, scene, error)),
        Err(SolveError::Run(error)) => return Err(error),
        Err(SolveError::Scene(objection)) => return Err(object(objection)),
    };
    print(&answer.notes);
    notes.extend_from_slice(&answer.notes);
    for line in ranking(&plan, &answer) {
        run.progress.stage(&line);
    }
    let (mut files, motion) = fields.finish().map_err(RunError::Solver)?;
    let gauges = by_gauge(scene, &plan, &answer.responses);
    let failure =
        |(sample, reason): &(u64, String)| Failure { sample: *sample, reason: reason.clone() };
    let content = Content {
        work: WorkRecord {
            particles: experiment.n_particles(),
            steps: answer.n_steps,
            runs: answer.n_runs,
            cpu_seconds: answer.cpu_seconds,
        },
        files: scene.files(),
        notes,
        random_fields: experiment.fields().iter().map(FieldResult::of).collect(),
        failures: answer.failures.iter().map(failure).collect(),
        multilevel: answer.multilevel,
        balance: answer.balance,
        gauges,
    };
    let answers = answers::answers(scene, &content);
    Ok(Completed::here(run, answers, || {
        let mut report = findings::report(scene, &content);
        let drawings = report.drawn("charts", drawings(scene, &plan, &content.gauges));
        let result = ResultFile::new("response-moments/1", scene, &content)?;
        if let Some((folder, csv)) = run.folder().zip(balance::csv(scene, &content.balance)) {
            let path = folder.join("balance.csv");
            write_text(&path, &csv).map_err(RunError::solver)?;
            files.push(path);
        }
        Ok(Output { result, files, drawings, motions: motion.into_iter().collect(), report })
    }))
}

const OTHER_TIMES: &str = "a run resumes only from a checkpoint with the same earlier times; --overwrite starts from the beginning";

/// Reports an error caused by a key of the scene at that key.
fn in_the_scene(file: &SceneFile, scene: &SmpmScene, error: smpm::Error) -> RunError {
    let at =
        |path: String| RunError::from(file.object_to(&Objection::new(path, error.to_string())));
    let gauge = |name: &str| scene.gauges.iter().position(|gauge| gauge.name == name);
    match &error {
        smpm::Error::LikelyOutOfRange { parameter, .. } => {
            at(format!("random[{parameter}].coefficient_of_variation"))
        }
        smpm::Error::GaugeOutsideBody { name, .. }
        | smpm::Error::EmptyGauge { name, .. }
        | smpm::Error::NoLocalFormulas { name } => match gauge(name) {
            Some(i) => at(format!("gauges[{i}]")),
            None => RunError::solver(error),
        },
        smpm::Error::ShortStep { .. } => at(match scene.method {
            MethodScene::ForwardDifference { .. } => "method.forward_difference.step".to_owned(),
            _ => "method.finite_difference.step".to_owned(),
        }),
        smpm::Error::AtParticle { .. } => at("random_fields".to_owned()),
        smpm::Error::WindowOrder { .. } => at("times".to_owned()),
        smpm::Error::OtherWindows { .. } => {
            let objection = Objection::new("times", error.to_string());
            file.object_to(&objection.with_help(OTHER_TIMES)).into()
        }
        smpm::Error::RigidAlone | smpm::Error::NoFaceLoaded { .. } => at("bodies".to_owned()),
        smpm::Error::NotOnGrid { .. }
        | smpm::Error::BoundariesTooClose { .. }
        | smpm::Error::BoundariesContradict { .. }
        | smpm::Error::AxisIsNoBoundary => at("boundaries".to_owned()),
        _ => RunError::solver(error),
    }
}

/// The parameters of each response at the last time, the one with the largest total index first.
fn ranking<const D: usize>(plan: &Plan<D>, answer: &Answer) -> Vec<String> {
    let last = plan.windows.len().saturating_sub(1);
    let of = |(i, response): (usize, &Response)| {
        let (gauge, quantity, window) = plan.parts(i);
        if window != last || response.sobol_indices.is_empty() {
            return None;
        }
        let mut shares: Vec<&Shares> = response.sobol_indices.iter().collect();
        shares.sort_by(|a, b| b.total.total_cmp(&a.total));
        let word = |share: &&Shares| {
            let error = share.total_standard_error.map(|error| format!("± {:.1} %", 100.0 * error));
            let error = error.unwrap_or_else(|| "error unknown".to_owned());
            format!("{} {:.1} % ({error})", share.parameter, 100.0 * share.total)
        };
        let words: Vec<String> = shares.iter().map(word).collect();
        let (name, quantity) = (&plan.gauges[gauge].name, plan.quantities[quantity]);
        Some(format!("total Sobol' indices of {quantity} at {name}: {}", words.join(", ")))
    };
    answer.responses.iter().enumerate().filter_map(of).collect()
}

/// One chart for each quantity: every gauge with a band of one standard deviation.
fn drawings<const D: usize>(
    scene: &SmpmScene,
    plan: &Plan<D>,
    gauges: &[GaugeResult],
) -> Result<Vec<Drawing>, RunError> {
    if plan.windows.len() < 2 {
        return Ok(Vec::new());
    }
    let draw = |q: usize| {
        let [_, time, ..] = scene.units.names();
        let (name, unit) = (&gauges[0].quantities[q].name, gauges[0].quantities[q].unit);
        let of = |gauge: &'_ GaugeResult| gauge.quantities[q].values.clone();
        let lines = gauges.iter().map(|gauge| Line {
            name: gauge.name.clone(),
            points: of(gauge).iter().map(|value| (value.time(), Some(value.mean))).collect(),
        });
        let bands = gauges.iter().map(|gauge| Band {
            points: of(gauge)
                .iter()
                .filter_map(|value| {
                    let deviation = value.standard_deviation?;
                    Some((value.time(), value.mean - deviation, value.mean + deviation))
                })
                .collect(),
        });
        let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
        let chart = TimeSeries {
            words: Words {
                title: scene.title.clone(),
                subtitle: format!("{}; shaded: one standard deviation", method_words(scene.method)),
                x_label: format!("time ({time})"),
                y_label: format!("{}{unit}", name.replace('_', " ")),
                caption: vec![Machine::read().caption()],
            },
            scale: Scale::Linear,
            lines: lines.collect(),
            bands: bands.collect(),
            references: Vec::new(),
        };
        Drawing::time_series(name, &chart).map_err(RunError::solver)
    };
    (0..plan.quantities.len()).map(draw).collect()
}

fn method_words(method: MethodScene) -> String {
    match method {
        MethodScene::Deterministic => "One run at the centre of the parameters".to_owned(),
        MethodScene::Frozen { as_printed: true } => {
            "Derivatives at the local state as printed by Chen et al. 2019".to_owned()
        }
        MethodScene::Frozen { .. } => "Derivatives at the local state, corrected".to_owned(),
        MethodScene::Propagated => {
            "Mean and deviation by derivatives carried through one run".to_owned()
        }
        MethodScene::FiniteDifference { .. } => {
            "Mean and deviation by differences of whole runs".to_owned()
        }
        MethodScene::ForwardDifference { .. } => {
            "Centre and deviation by one-sided differences of whole runs".to_owned()
        }
        MethodScene::SigmaPoints => "Mean and deviation by sigma points".to_owned(),
        MethodScene::MonteCarlo { samples, .. } => {
            format!("Mean and deviation of {samples} sampled runs")
        }
        MethodScene::QuasiMonteCarlo { points, replicas, .. } => {
            format!("Mean and deviation of runs at {replicas} x {points} Sobol' points")
        }
        MethodScene::SobolIndices { points, replicas, .. } => {
            format!("Mean and deviation of runs for Sobol' indices at {replicas} x {points} points")
        }
        MethodScene::Multilevel(_) => {
            "Mean and deviation of sampled runs on grids of doubling cells".to_owned()
        }
    }
}
