//! Result of a sweep: schema `sweep/1`, and its answers.

use result_figures::number::{counted, tidy};
use scene_runs::answers::{Answer, AnswerValue, Answers, ErrorOrigin, Number, Role, Statistic};
use scene_runs::scene::NamedFile;
use serde::Serialize;
use uq_estimators::QuantalResponse;

use super::residual_velocity::ResidualVelocity;
use super::swept_runs::{SweptRun, SweptRuns, in_order};
use crate::run::record::{Failure, WorkRecord};
use crate::scene::SmpmScene;
use crate::sweep_scene::SweepScene;

/// Two levels between which the event begins, in parts of the range.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bracket {
    pub(super) without: f64,
    pub(super) with: f64,
}

/// What a sweep looks for beside the bracket.
pub(super) enum Found {
    /// Nothing.
    Limit,
    /// The probability over the number.
    Probability(QuantalResponse),
}

/// Keys of the result of a sweep: schema `sweep/1`.
#[derive(Debug, Serialize)]
pub(super) struct SweepContent {
    pub(super) work: WorkRecord,
    /// Files that the scene names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<NamedFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) notes: Vec<String>,
    /// Runs that failed, and why.
    failures: Vec<Failure>,
    pub(super) sweep: SweepResult,
}

/// What a sweep found.
#[derive(Debug, Serialize)]
pub(super) struct SweepResult {
    number: String,
    pub(super) unit: &'static str,
    event: String,
    /// Values without and with the event, at the centre of the parameters.
    pub(super) bracket_at_centre: [f64; 2],
    /// The limit: where the event begins at the centre, or, with random parameters, where half of the runs have it.
    pub(super) limit: Number,
    /// Standard deviation of the limit over the random parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) deviation_of_limit: Option<Number>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) probabilities: Vec<ProbabilityAt>,
    /// Fit of residual velocities, where a velocity is swept and a velocity decides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) residual_velocity: Option<ResidualVelocity>,
    /// All runs by value of the number.
    pub(super) runs: Vec<SweptRun>,
}

/// Probability of the event at a value.
#[derive(Debug, Serialize)]
pub(super) struct ProbabilityAt {
    pub(super) value: f64,
    pub(super) probability: f64,
    /// Interval of 95 %.
    pub(super) interval: [f64; 2],
}

impl SweepContent {
    pub(super) fn new<const D: usize>(
        (scene, sweep): (&SmpmScene, &SweepScene),
        runs: &SweptRuns<'_, D>,
        (bracket, found): (Bracket, &Found),
        (work, notes, failures): (WorkRecord, Vec<String>, Vec<Failure>),
    ) -> Self {
        let ends = [bracket.without, bracket.with].map(|level| sweep.value(level));
        let half = 0.5 * (ends[1] - ends[0]).abs();
        let middle = 0.5 * (ends[0] + ends[1]);
        let at_centre = Number { value: middle, error: Some(half), error_kind: ErrorOrigin::Bound };
        let range = sweep.to - sweep.from;
        let (mut limit, mut deviation_of_limit, mut probabilities) = (at_centre, None, Vec::new());
        if let Found::Probability(model) = found {
            let (median, deviation) = (model.median(), model.deviation());
            let error = |estimate: sde_integrators::Estimate| {
                estimate.standard_error().map(|error| error * range.abs())
            };
            limit = Number::sampled(sweep.value(median.value), error(median));
            deviation_of_limit =
                Some(Number::sampled(deviation.value * range.abs(), error(deviation)));
            let of = |value: f64| {
                let band = model.probability(sweep.level(value));
                ProbabilityAt { value, probability: band.value, interval: band.interval }
            };
            probabilities = sweep.values().into_iter().map(of).collect();
        }
        let result = SweepResult {
            number: sweep.number.clone(),
            unit: scene.unit_at(&sweep.number),
            event: sweep.event.name.clone(),
            bracket_at_centre: ends,
            limit,
            deviation_of_limit,
            probabilities,
            residual_velocity: residual_velocity(scene, sweep, runs.all()),
            runs: in_order(runs.all()).into_iter().cloned().collect(),
        };
        Self { work, files: scene.files(), notes, failures, sweep: result }
    }
}

/// The fit of residual velocities, if both numbers are velocities.
fn residual_velocity(
    scene: &SmpmScene,
    sweep: &SweepScene,
    runs: &[SweptRun],
) -> Option<ResidualVelocity> {
    let is_velocity = scene.unit_at(&sweep.number) == scene.units.names()[4]
        && sweep.event.quantity.starts_with("velocity");
    let point = |it: &SweptRun| Some((it.value.abs(), it.outcome?[1].abs()));
    let points: Vec<(f64, f64)> =
        runs.iter().filter(|it| it.is_event(sweep)).filter_map(point).collect();
    is_velocity.then(|| ResidualVelocity::fit(&points))?
}

impl ProbabilityAt {
    /// The larger distance of an end of the interval.
    pub(super) fn error(&self) -> f64 {
        let [low, high] = self.interval;
        (self.probability - low).max(high - self.probability)
    }
}

/// The limit, its deviation and the probabilities.
pub(super) fn answers(sweep: &SweepScene, content: &SweepContent) -> Answers {
    let (number, event) = (&sweep.number, &sweep.event.name);
    let result = &content.sweep;
    let is_random = result.deviation_of_limit.is_some();
    let n_sampled = result.runs.iter().filter(|it| it.sample.is_some()).count();
    let of_model = format!("probit model of {}", counted(n_sampled, "run"));
    let answer = |id: &str, words: String, statistic, number: Number, remark: Option<String>| {
        let last = AnswerValue { remark, ..AnswerValue::of(number) };
        let unit = match statistic {
            Statistic::Probability => "",
            _ => result.unit,
        };
        let (unit, role) = (unit.to_owned(), Role::Headline);
        Answer { unit, role, ..Answer::new(format!("sweep/{id}"), words, statistic, last) }
    };
    let words = if is_random {
        format!("median limit: {number} at which half of the runs are {event}")
    } else {
        format!("limit: {number} from which the run is {event}")
    };
    let remark = if is_random {
        format!("standard deviation of the posterior of a {of_model}")
    } else {
        "half of the bracket, on this grid".to_owned()
    };
    let mut list = vec![answer("limit", words, Statistic::Mean, result.limit, Some(remark))];
    if let Some(deviation) = result.deviation_of_limit {
        let words = format!("standard deviation of the limit of {number}");
        let remark = format!("standard deviation of the posterior of a {of_model}");
        let statistic = Statistic::StandardDeviation;
        list.push(answer("deviation", words, statistic, deviation, Some(remark)));
    }
    for it in &result.probabilities {
        let unit = if result.unit.is_empty() { String::new() } else { format!(" {}", result.unit) };
        let words = format!("probability of {event} at {}{unit}", tidy(it.value));
        let number = Number {
            value: it.probability,
            error: Some(it.error()),
            error_kind: ErrorOrigin::Interval,
        };
        let remark = format!("larger side of the 95 % interval of a {of_model}");
        let id = format!("probability/{}", tidy(it.value));
        list.push(answer(&id, words, Statistic::Probability, number, Some(remark)));
    }
    Answers { cpu_seconds: content.work.cpu_seconds, list }
}
