//! A sweep over one number of a scene: the limit at which an event begins, or the probability of the event over that number.
//!
//! Without random parameters the limit is bracketed by rounds of runs. With them a bracket at the centre comes first; then every run
//! has parameters of its own and a value of the number near the limit, and a probit model of the outcomes gives the probability.

mod drawn;
mod record;
mod residual_velocity;
mod swept_runs;

use result_figures::number::{counted, tidy};
use scene_runs::kind::{Completed, Output, Run};
use scene_runs::result_file::ResultFile;
use scene_runs::scene::Objection;
use smpm::Error;
use uq_estimators::{QuantalResponse, Trial};

use self::record::{Bracket, Found, SweepContent};
use self::swept_runs::{SweptRun, SweptRuns};
use super::record::{Failure, WorkRecord};
use super::solve_error::SolveError;
use crate::method_scene::MethodScene;
use crate::scene::SmpmScene;
use crate::sweep_scene::SweepScene;

/// Runs of a round by which a bracket is divided.
const BRACKET_ROUND: usize = 2;
/// Runs of a round with random parameters; the values of a round follow from all rounds before.
const ROUND: usize = 4;
/// Runs with random parameters before the band of the probability may end them.
const FEWEST_RUNS: usize = 20;
/// Width of the bracket at the centre before runs with random parameters, in ranges.
const FIRST_BRACKET: f64 = 0.05;
/// Largest share of runs that may fail.
const MOST_FAILED: f64 = 0.05;

/// Runs the sweep of a scene.
pub(super) fn solve<const D: usize>(
    scene: &SmpmScene,
    sweep: &SweepScene,
    mut notes: Vec<String>,
    run: &Run<'_>,
) -> Result<Completed, SolveError> {
    let mut runs = SweptRuns::<D>::new(scene, sweep, run)?;
    run.progress.stage("bracket at the centre of the parameters");
    let range = (sweep.to - sweep.from).abs();
    let width = match scene.method {
        MethodScene::MonteCarlo { .. } => FIRST_BRACKET,
        _ => sweep.bracket() / range,
    };
    let bracket = bracketed(sweep, width, &mut runs, &mut notes)?;
    let found = match scene.method {
        MethodScene::MonteCarlo { samples, .. } => {
            run.progress.stage("runs with random parameters");
            let model = sampled(sweep, samples, &mut runs)?;
            if runs.n_sampled() as u64 == samples && !is_known(&model, sweep) {
                notes.push(format!(
                    "the half width of the probability is above {} after all {}: allow more `samples` or a wider `band`",
                    tidy(sweep.band),
                    counted(runs.n_sampled(), "run"),
                ));
            }
            Found::Probability(model)
        }
        _ => Found::Limit,
    };
    let failures = failures(runs.all())?;
    notes.extend(failed_note(&failures, runs.all().len()));
    notes.extend(unfinished(scene, sweep, &runs));
    let work = WorkRecord {
        particles: runs.n_particles(),
        steps: runs.all().iter().map(|it| it.n_steps).max().unwrap_or_default(),
        runs: runs.all().len() as u64,
        cpu_seconds: runs.cpu_seconds(),
    };
    let content =
        SweepContent::new((scene, sweep), &runs, (bracket, &found), (work, notes, failures));
    let answers = record::answers(sweep, &content);
    Ok(Completed::here(run, answers, || {
        let mut report = drawn::report(scene, sweep, &content);
        let drawings = report.drawn("charts", drawn::drawings(scene, sweep, &content, &found));
        let result = ResultFile::new("sweep/1", scene, &content)?;
        Ok(Output { result, files: Vec::new(), drawings, motions: Vec::new(), report })
    }))
}

/// The bracket of the limit at the centre, in parts of the range.
fn bracketed<const D: usize>(
    sweep: &SweepScene,
    width: f64,
    runs: &mut SweptRuns<'_, D>,
    notes: &mut Vec<String>,
) -> Result<Bracket, SolveError> {
    let occurs = |it: &SweptRun| it.is_event(sweep);
    let ends = runs.round(&[(0.0, None), (1.0, None)])?;
    let (name, help) = (&sweep.event.name, "write a range about the limit");
    for (key, end, is_expected) in [("from", &ends[0], false), ("to", &ends[1], true)] {
        if occurs(end) != is_expected {
            let not = if is_expected { "not " } else { "" };
            let message = format!("at {} the run is {not}{name}", tidy(end.value));
            return Err(Objection::new(format!("sweep.{key}"), message).with_help(help).into());
        }
    }
    let mut bracket = Bracket { without: 0.0, with: 1.0 };
    while bracket.with - bracket.without > width {
        let step = (bracket.with - bracket.without) / (BRACKET_ROUND + 1) as f64;
        let levels: Vec<_> =
            (1..=BRACKET_ROUND).map(|k| (bracket.without + k as f64 * step, None)).collect();
        let outcomes = runs.round(&levels)?;
        let first = outcomes.iter().position(occurs).unwrap_or(BRACKET_ROUND);
        if let Some(later) = outcomes[first..].iter().find(|it| !occurs(it)) {
            notes.push(format!(
                "the event is not monotone: the run is {name} at {} and not at {}; the limit is the first at which it is",
                tidy(outcomes[first].value),
                tidy(later.value),
            ));
        }
        let without = bracket.without + first as f64 * step;
        bracket = Bracket { without, with: (without + step).min(bracket.with) };
    }
    Ok(bracket)
}

/// The probit model of runs with random parameters; their levels follow from the runs before.
fn sampled<const D: usize>(
    sweep: &SweepScene,
    samples: u64,
    runs: &mut SweptRuns<'_, D>,
) -> Result<QuantalResponse, SolveError> {
    let model = |trials: &[Trial]| QuantalResponse::new([0.0, 1.0], trials).map_err(Error::from);
    loop {
        let n = runs.n_sampled();
        // Runs at the centre show where to search; they are no trials of random parameters.
        let known = model(&runs.trials(|_| true))?;
        let of_samples = model(&runs.trials(|it| it.sample.is_some()))?;
        let left = samples - n as u64;
        if left == 0 || n >= FEWEST_RUNS && is_known(&of_samples, sweep) {
            return Ok(of_samples);
        }
        let next = usize::try_from(left).map_or(ROUND, |left| ROUND.min(left));
        let levels = known.next_levels(n, next);
        let asked: Vec<_> =
            levels.into_iter().zip(n as u64..).map(|(level, k)| (level, Some(k))).collect();
        runs.round(&asked)?;
        failures(runs.all())?;
    }
}

/// Whether the band of the probability is as narrow as asked for, at every value.
fn is_known(model: &QuantalResponse, sweep: &SweepScene) -> bool {
    let half = |value: &f64| model.probability(sweep.level(*value)).half_width();
    sweep.values().iter().all(|value| half(value) <= sweep.band)
}

/// Runs that failed; an error where these are so many that the rest would mislead.
fn failures(runs: &[SweptRun]) -> Result<Vec<Failure>, SolveError> {
    let of = |it: &SweptRun| Some(Failure { sample: it.sample?, reason: it.failure.clone()? });
    let failures: Vec<Failure> = runs.iter().filter_map(of).collect();
    let (failed, n) = (failures.len(), runs.iter().filter(|it| it.sample.is_some()).count());
    match failures.first() {
        // One of the first runs is not yet a share.
        Some(first) if failed > 1 && failed as f64 > MOST_FAILED * n as f64 => {
            let Failure { sample, reason } = first.clone();
            Err(Error::SamplesFailed { failed, n, sample, reason }.into())
        }
        _ => Ok(failures),
    }
}

fn failed_note(failures: &[Failure], n: usize) -> Option<String> {
    let first = failures.first()?;
    let failed = counted(failures.len(), "run");
    Some(format!("{failed} of {n} ended in an error and did not count: {}", first.reason))
}

/// A note on runs whose outcome may change after the last time: another change as large as that since the time before would do.
fn unfinished<const D: usize>(
    scene: &SmpmScene,
    sweep: &SweepScene,
    runs: &SweptRuns<'_, D>,
) -> Option<String> {
    let is_unfinished = |it: &&SweptRun| {
        it.outcome.is_some_and(|[before, last]| {
            sweep.event.occurs(last) != sweep.event.occurs(2.0 * last - before)
        })
    };
    let n = runs.all().iter().filter(is_unfinished).count();
    (n > 0 && scene.times.len() > 1).then(|| {
        format!(
            "{} of {} may have another outcome after the last time: `{}` at `{}` still changes; add a later one to `times`",
            counted(n, "run"),
            runs.all().len(),
            sweep.event.quantity,
            sweep.event.gauge,
        )
    })
}
