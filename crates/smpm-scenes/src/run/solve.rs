//! Methods of a scene.

use std::path::PathBuf;

use perturbation_moments::Jet;
use scene_runs::checkpoint::Checkpoint;
use scene_runs::kind::{EnsemblePart, Inputs, Run, RunError};
use smpm::uncertainty::{FrozenForm, Sampled, Series, SeriesError, Study};
use smpm::{Error, Plan, Simulation};

use super::balance::{BalanceRecord, records};
use super::fields::Fields;
use super::kept::KeptRuns;
use super::levels::multilevel_record::MultilevelRecord;
use super::response::{Response, Table};
use super::samples::{ASIDE_OF_SAMPLES, Requested, Samples, sampled, shards};
use super::solve_error::SolveError;
use crate::experiment::SceneExperiment;
use crate::method_scene::MethodScene;
use crate::scene::SmpmScene;

/// Keys that do not affect a run up to the first differing time, which the stored state records.
const ASIDE: [&str; 3] = ["/title", "/levels", "/times"];
/// Sample of random fields that is written for ParaView.
const SHOWN: u64 = 0;
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
    /// What a reader must know of the estimate.
    pub(super) notes: Vec<String>,
    /// Grids of a multilevel estimate.
    pub(super) multilevel: Option<MultilevelRecord>,
    /// Balance of the reference run.
    pub(super) balance: Vec<BalanceRecord>,
}

/// Runs the method of a scene whose parameters or fields are random.
pub(super) fn solve<'a, const D: usize>(
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

/// Checkpoint of a scene whose samples are neither merged nor distributed over ranks.
pub(super) fn checkpoint<'a>(
    scene: &SmpmScene,
    run: &'a Run<'_>,
) -> Result<Option<&'a Checkpoint>, RunError> {
    if run.ranks().is_some() || matches!(run.part(), EnsemblePart::Merged(_)) {
        return Ok(None);
    }
    let (seed, aside) = match scene.design() {
        Some(design) => (Some(design.seed()), ASIDE_OF_SAMPLES.as_slice()),
        None => (None, ASIDE.as_slice()),
    };
    run.checkpoint(&Inputs { scene, seed, files: &scene.files() }, aside).map(Some)
}

/// Solves the scene with runs that resume from stored ones.
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
    let study = Study::kept_by(experiment, experiment.inputs(), plan.clone(), kept)?;
    let table = Table { scene, plan, centre: study.centre() };
    let (mut failures, mut n_runs, mut seconds_elsewhere) = (Vec::new(), 1, 0.0);
    let has_fields = !scene.random_fields.is_empty();
    // The fields of a scene are those of one realisation.
    let mut shown = has_fields.then(|| vec![0.0; study.n_normals()]);
    let responses = if let Some(design) = scene.design() {
        n_runs += design.n_runs()?;
        if has_fields {
            shown = Some(study.normals(design.seed(), SHOWN));
        }
        run.progress.stage("samples");
        let requested = Requested { scene, study: &study, design };
        let sampled = match sampled(&requested, run, kept, shards)? {
            Samples::All(sampled, elsewhere) => {
                seconds_elsewhere = elsewhere;
                sampled
            }
            Samples::Shard(file) => return Ok(Solved::Shard(file)),
            Samples::Elsewhere => return Ok(Solved::Elsewhere),
        };
        let mut surrogates = Vec::new();
        if scene.method.has_taylor_control() && has_fields {
            run.progress.stage("runs with derivatives, for the control variate");
            let propagated = study.propagated()?;
            n_runs += propagated.n_runs as u64;
            surrogates = propagated.moments;
        } else if scene.method.has_taylor_control() {
            run.progress.stage("differences of whole runs, for the control variate");
            n_runs += 2 * experiment.n_random() as u64;
            surrogates = study.finite_difference(DIFFERENCE)?;
        }
        failures = sampled.failures.iter().map(|(id, e)| (*id, e.to_string())).collect();
        of_samples(&table, &sampled, &surrogates)?
    } else {
        let (responses, more_runs) = expanded(&study, &table, experiment, fields, run)?;
        n_runs += more_runs;
        responses
    };
    if let Some(normals) = shown {
        fields.of_realisation(&study, &normals, experiment)?;
    }
    let cpu_seconds = kept.cpu_seconds() + seconds_elsewhere;
    let n_steps = study.schedule().n_steps();
    let (notes, multilevel) = (scene.torn(study.torn()), None);
    let balance = records(scene, study.balance());
    Ok(Solved::Whole(Answer {
        responses,
        n_steps,
        n_runs,
        cpu_seconds,
        failures,
        notes,
        multilevel,
        balance,
    }))
}

/// Responses from samples: with a Taylor series or a fitted polynomial as control variate, with Sobol' indices, or as they are.
fn of_samples<const D: usize>(
    table: &Table<'_, D>,
    sampled: &Sampled,
    surrogates: &[Series],
) -> Result<Vec<Response>, Error> {
    let polynomial = match table.scene.method {
        MethodScene::QuasiMonteCarlo { control: true, .. } => Some(sampled.polynomial_control()?),
        _ => None,
    };
    let failed_share = Some(sampled.failed_share()).filter(|&share| share > 0.0);
    table.each(|i, response| {
        let mut shares = Vec::new();
        let found = match (&polynomial, surrogates.get(i)) {
            (Some(polynomial), _) => {
                let found = polynomial.moments(&sampled.values(i)?)?;
                // Of correlated parameters the normals behind them have indices, and these are no shares of the parameters.
                if table.scene.correlations.iter().all(|it| it.value == 0.0) {
                    shares = table.shares(&found.first, &found.total, Some(found.unexplained));
                }
                found.moments
            }
            (None, Some(series)) => sampled.controlled(i, series)?,
            (None, None) => sampled.raw(i)?,
        };
        let is_design = matches!(table.scene.method, MethodScene::SobolIndices { .. });
        if is_design && found.variance.value > 0.0 {
            let indices = sampled.sobol_indices(i)?;
            shares = table.shares(&indices.first, &indices.total, None);
        }
        let chances = table.levels(i).iter().map(|&level| sampled.exceedance(i, level));
        let moments = (&found.mean, &found.variance);
        let response = table.estimated(i, response, moments, ("count", chances))?;
        let is_followed = polynomial.is_some() || surrogates.get(i).is_some();
        let n_followed = is_followed.then(|| sampled.n_samples() as u64);
        Ok(Response { sobol_indices: shares, failed_share, n_followed, ..response })
    })
}

/// Responses by a method without samples, and its number of runs besides the reference run.
fn expanded<const D: usize>(
    study: &Study<'_, SceneExperiment<D>, D>,
    table: &Table<'_, D>,
    experiment: &SceneExperiment<D>,
    fields: &mut Fields<'_>,
    run: &Run<'_>,
) -> Result<(Vec<Response>, u64), Error> {
    let n = experiment.n_random() as u64;
    let has_fields = !table.scene.random_fields.is_empty();
    let of_series = |series: Vec<Series>, step: f64| {
        run.progress.stage("check runs of the series");
        let errors = study.series_errors(&series, step)?;
        let responses = table.each(|i, response| {
            let SeriesError { mean, standard_deviation } = errors[i];
            let known = |error: f64| Some(error).filter(|error| error.is_finite());
            let (mean_error, standard_deviation_error) = (known(mean), known(standard_deviation));
            let response = table.taylor(i, response, &series[i], None)?;
            Ok(Response { mean_error, standard_deviation_error, ..response })
        })?;
        Ok::<_, Error>((responses, study.n_check_runs(step)))
    };
    Ok(match table.scene.method {
        MethodScene::Deterministic
        | MethodScene::MonteCarlo { .. }
        | MethodScene::QuasiMonteCarlo { .. }
        | MethodScene::SobolIndices { .. }
        | MethodScene::Multilevel(_) => {
            if !has_fields {
                fields.of_realisation(study, &vec![0.0; study.n_normals()], experiment)?;
            }
            (table.each(|_, response| Ok(response))?, 0)
        }
        MethodScene::Frozen { as_printed } => {
            run.progress.stage("local formulas");
            let form = if as_printed { FrozenForm::Printed } else { FrozenForm::Corrected };
            let series = study.frozen(form)?;
            let of = |i: usize, response| match &series[i] {
                Some(series) => table.taylor(i, response, series, None),
                None => Ok(response),
            };
            (table.each(of)?, 1)
        }
        MethodScene::Propagated => {
            run.progress.stage("run with derivatives");
            let propagated = study.propagated_seen(|time, run: &Simulation<Jet, D>| {
                if !has_fields {
                    fields.of_jets(time, run, table.scene.random.len());
                }
            })?;
            fields.are_shown();
            let of = |i: usize, response| {
                let switch = Some(&propagated.switches[i]);
                table.taylor(i, response, &propagated.moments[i], switch)
            };
            (table.each(of)?, propagated.n_runs as u64)
        }
        MethodScene::FiniteDifference { step } => {
            run.progress.stage("differences of whole runs");
            let (responses, n_checks) = of_series(study.finite_difference(step)?, step)?;
            (responses, 2 * n + n_checks)
        }
        MethodScene::ForwardDifference { step } => {
            run.progress.stage("one-sided differences of whole runs");
            let (responses, n_checks) = of_series(study.forward_difference(step)?, step)?;
            (responses, n + n_checks)
        }
        MethodScene::SigmaPoints => {
            run.progress.stage("sigma points");
            let points = study.sigma_points()?;
            let of = |i: usize, response: Response| {
                Ok(response.with_moments(points[i].mean(), points[i].surrogate_variance()))
            };
            (table.each(of)?, 2 * n)
        }
    })
}
