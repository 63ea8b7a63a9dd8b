//! Methods of a scene with random fields.

use perturbation_moments::MonteCarlo;
use scene_runs::kind::{Run, RunError};
use smpm::uncertainty::{Design, FieldMoments, FieldStudy, Switch};
use smpm::{Error, Plan};

use super::fields::Fields;
use super::kept::KeptRuns;
use super::response::{Response, Table};
use super::samples::{Requested, Samples, SeenSamples, sampled, shards};
use super::solve::{Answer, SolveError, Solved, checkpoint};
use crate::experiment::SceneExperiment;
use crate::method_scene::MethodScene;
use crate::scene::SmpmScene;

/// Sample whose fields are written for ParaView.
const SHOWN: u64 = 0;

/// Runs the method of a scene whose constants vary in space.
pub(super) fn solve_fields<'a, const D: usize>(
    scene: &SmpmScene,
    experiment: &SceneExperiment<D>,
    plan: &Plan<D>,
    fields: &mut Fields<'a>,
    run: &'a Run<'_>,
) -> Result<Solved, SolveError> {
    let kept = KeptRuns::new(checkpoint(scene, run)?, run);
    fields.resume(kept.checkpoint).map_err(RunError::from)?;
    let solved = solve_kept(scene, experiment, plan, fields, run, &kept);
    // The study knows only that it was not kept.
    kept.into_failure().map_or(solved, |failure| Err(SolveError::Run(failure)))
}

fn solve_kept<const D: usize>(
    scene: &SmpmScene,
    experiment: &SceneExperiment<D>,
    plan: &Plan<D>,
    fields: &mut Fields<'_>,
    run: &Run<'_>,
    kept: &KeptRuns<'_>,
) -> Result<Solved, SolveError> {
    // A file that is no shard of this scene is rejected before any run.
    let shards = shards(scene, plan, run)?;
    run.progress.stage("reference run");
    let study = FieldStudy::new(experiment, plan.clone(), Some(kept))?;
    let table = Table { scene, plan, centre: study.centre() };
    let n_terms = experiment.fields().iter().map(|field| field.n_terms).sum();
    let mut shown = vec![0.0; n_terms];
    let (mut failures, mut n_runs, mut seconds_elsewhere) = (Vec::new(), 1, 0.0);
    let responses = match scene.method {
        MethodScene::MonteCarlo { samples, seed, control } => {
            n_runs += samples;
            shown = study.coefficients(seed, SHOWN);
            run.progress.stage("samples");
            let judge = MonteCarlo { seed, n_samples: samples };
            let run_samples = |_: Design, range, known: &_, each, seen: &mut SeenSamples<'_>| {
                let mut seen = |so_far: &_, tried| Ok::<(), SolveError>(seen(so_far, tried)?);
                study
                    .monte_carlo_from(judge, range, known, each, &mut seen)
                    .map_err(SolveError::of_runs)
            };
            let design = Design::Random(judge);
            let requested = Requested { scene, plan, design, run_samples: &run_samples };
            let sampled = match sampled(&requested, run, kept, shards)? {
                Samples::All(sampled, elsewhere) => {
                    seconds_elsewhere = elsewhere;
                    sampled
                }
                Samples::Shard(file) => return Ok(Solved::Shard(file)),
                Samples::Elsewhere => return Ok(Solved::Elsewhere),
            };
            let mut series = None;
            if control {
                run.progress.stage("runs with derivatives, for the control variate");
                let gradient = study.gradient()?;
                n_runs += gradient.n_runs as u64;
                series = Some(gradient.moments);
            }
            failures = sampled.failures.iter().map(|(id, e)| (*id, e.to_string())).collect();
            table.each(|i, response| {
                let found = match &series {
                    Some(series) => sampled.controlled_by_fields(i, &series[i])?,
                    None => sampled.raw(i)?,
                };
                table.sampled(i, response, &sampled, (&found.mean, &found.variance))
            })?
        }
        MethodScene::Deterministic => table.each(|_, response| Ok(response))?,
        method => {
            run.progress.stage("derivatives of fields");
            let (series, switches, more_runs) = expanded(&study, method)?;
            n_runs += more_runs;
            table
                .each(|i, response| of_series(&table, i, response, (&series[i], switches.get(i))))?
        }
    };
    fields.of_realisation(&study, &shown, experiment)?;
    let cpu_seconds = kept.cpu_seconds() + seconds_elsewhere;
    let n_steps = study.schedule().n_steps();
    let (notes, multilevel) = (Vec::new(), None);
    let answer = Answer { responses, n_steps, n_runs, cpu_seconds, failures, notes, multilevel };
    Ok(Solved::Whole(answer))
}

/// Taylor series of all responses, distances to switches where they are known, and the number of runs besides the reference.
fn expanded<const D: usize>(
    study: &FieldStudy<'_, SceneExperiment<D>, D>,
    method: MethodScene,
) -> Result<(Vec<FieldMoments>, Vec<Switch>, u64), Error> {
    let series = |derivatives: Vec<Vec<[f64; 2]>>| {
        let of = |(&value, along): (&f64, Vec<[f64; 2]>)| {
            let (gradient, curvature) = along.into_iter().map(|[g, h]| (g, h)).unzip();
            FieldMoments { value, gradient, curvature }
        };
        study.centre().iter().zip(derivatives).map(of).collect()
    };
    let units = study.units();
    let n = units.len() as u64;
    // Without curvature the mean is that of first order.
    let flat = |slopes: Vec<f64>| slopes.into_iter().map(|slope| [slope, 0.0]).collect();
    Ok(match method {
        MethodScene::FiniteDifference { step } => {
            (series(study.central_differences(step, &units)?), Vec::new(), 2 * n)
        }
        MethodScene::ForwardDifference { step } => {
            let slopes = study.forward_differences(step, &units)?;
            (series(slopes.into_iter().map(flat).collect()), Vec::new(), n)
        }
        _ => {
            let found = study.gradient()?;
            (found.moments, found.switches, found.n_runs as u64)
        }
    })
}

/// A response with the moments of its series. The trust indicator knows the own curvatures of the terms, not the mixed ones.
fn of_series<const D: usize>(
    table: &Table<'_, D>,
    i: usize,
    response: Response,
    (series, switch): (&FieldMoments, Option<&Switch>),
) -> Result<Response, Error> {
    let variance = series.variance();
    let has_curvature = series.curvature.iter().any(|&curvature| curvature != 0.0);
    let ratio = (series.surrogate_variance() - variance) / variance;
    let ratio = Some(ratio).filter(|ratio| has_curvature && ratio.is_finite());
    table.series(i, response, (series.mean(), variance), (ratio, switch))
}
