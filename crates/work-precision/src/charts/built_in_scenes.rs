//! Every built-in scene by every method that solves it: error against CPU time.
//!
//! These charts and `advise` share one definition: the ladder of the scene's kind.

use result_figures::{Drawing, Measure, Method, Run, RunOutcome, Words, WorkPrecision};
use scenes::advise::{Advice, Judgement, Options, from_trials};
use scenes::answers::Statistic;
use scenes::ladder::{BuiltIn, Growth, Outcome, Trial};
use scenes::machine::Machine;

use super::cost::{cost_in_seconds, run};
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "scenes",
    title: "every built-in scene by every method that solves it: the largest error against CPU time",
    draw,
};

/// Largest cost of a trial (CPU s).
const fn budget(profile: Profile) -> f64 {
    match profile {
        Profile::Quick => 0.2,
        Profile::Default => 4.0,
        Profile::Full => 30.0,
    }
}

/// A trial cheaper than this (CPU s) runs three times, to measure the scatter of its cost.
const REPEATED: f64 = 0.5;

/// Quantities on one chart.
struct Group {
    /// What of random quantities they are.
    statistic: Statistic,
    /// Their values.
    values: std::ops::Range<f64>,
    /// Name in the title.
    words: &'static str,
    /// Name in the file name.
    stem: &'static str,
}

const ANY: std::ops::Range<f64> = f64::NEG_INFINITY..f64::INFINITY;
/// Limit between probabilities that thousands of paths resolve and those that require a tail method.
const SMALL: f64 = 1e-3;

const GROUPS: [Group; 5] = [
    Group { statistic: Statistic::Moment, values: ANY, words: "moments", stem: "moments" },
    Group {
        statistic: Statistic::Probability,
        values: SMALL..f64::INFINITY,
        words: "probabilities of 0.001 and more",
        stem: "probabilities",
    },
    Group {
        statistic: Statistic::Probability,
        values: f64::NEG_INFINITY..SMALL,
        words: "probabilities below 0.001",
        stem: "small-probabilities",
    },
    Group { statistic: Statistic::Mean, values: ANY, words: "means", stem: "means" },
    Group {
        statistic: Statistic::StandardDeviation,
        values: ANY,
        words: "standard deviations",
        stem: "standard-deviations",
    },
];

impl Group {
    fn holds(&self, judgement: &Judgement) -> bool {
        judgement.statistic == self.statistic && self.values.contains(&judgement.value)
    }
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let mut drawings = Vec::new();
    for scene in
        BuiltIn::all(scenes::ALL, &reference_problems::record::workspace().join("tests/scenes"))?
    {
        context.progress(&scene.name);
        let mut trials = scene.trials(budget(context.profile), |method, rung| {
            context.progress(&format!("  {}", method.at(&rung.label)));
        });
        let scatters: Vec<Option<f64>> =
            trials.iter_mut().map(|trial| repeat(&scene, trial)).collect();
        drawings.extend(drawings_of(&scene, trials, &scatters)?);
    }
    Ok(drawings)
}

/// Repeats a cheap trial twice: its cost becomes the median of three.
///
/// Returns half their range, or `None` for a single run.
fn repeat(scene: &BuiltIn, trial: &mut Trial) -> Option<f64> {
    if trial.answers().is_none_or(|answers| answers.cpu_seconds > REPEATED) {
        return None;
    }
    let costs = scene.costs(trial, 2);
    if let Outcome::Answered(answers) = &mut trial.outcome {
        answers.cpu_seconds = costs[costs.len() / 2];
    }
    Some(0.5 * (costs[costs.len() - 1] - costs[0]))
}

/// Charts of a scene; `scatters` are those of the costs of the trials.
fn drawings_of(
    scene: &BuiltIn,
    trials: Vec<Trial>,
    scatters: &[Option<f64>],
) -> Result<Vec<Drawing>, CaseError> {
    let title = scene.file.text_at_top("title").unwrap_or_default();
    let (folder, name) = scene.name.split_once('/').unwrap_or(("", &scene.name));
    let stem = format!("{folder}-scene-{}", name.replace('_', "-"));
    // The tolerance has no effect on the results of trials.
    let options = Options { tolerance: 0.01, budget: Options::BUDGET, quantities: Vec::new() };
    let advice = from_trials(scene.ladder.clone(), trials, &options)?;
    let mut drawings = Vec::new();
    for group in GROUPS {
        let of_group: Vec<usize> = (0..advice.judgements.len())
            .filter(|&q| group.holds(&advice.judgements[q]) && advice.is_known(q))
            .collect();
        let series = series(&advice, scatters, &of_group);
        if series.is_empty() {
            continue;
        }
        let data = WorkPrecision {
            words: words_of(&advice, &of_group, group.words, &title),
            reading: cost_in_seconds(Measure::Relative, 0.0),
            series,
        };
        drawings.push(Drawing::work_precision(&format!("{stem}-{}", group.stem), &data)?);
    }
    Ok(drawings)
}

fn words_of(advice: &Advice, of_group: &[usize], group: &str, title: &str) -> Words {
    let names: Vec<&str> = of_group.iter().map(|&q| advice.judgements[q].words.as_str()).collect();
    let shown = match names.as_slice() {
        [first, .., last] if names.len() > 3 => {
            format!("{first} to {last}, {} in all", names.len())
        }
        _ => names.join(", "),
    };
    Words {
        title: format!("Largest error of the {group}, against cost"),
        subtitle: title.to_owned(),
        x_label: "CPU time of one run, all threads (s)".into(),
        y_label: "largest relative error".into(),
        caption: vec![
            format!("At the last time: {shown}."),
            "Errors as in `advise`: the run's own estimate, two standard errors of samples, or the deviation from other runs.".into(),
            "Bars along the cost: half the range of three runs, below half a second.".into(),
            advice.ladder.left_out.to_owned(),
            Machine::read().caption(),
        ],
    }
}

/// One series for each method: the largest error over a group of quantities. Events without samples have no point.
fn series(advice: &Advice, scatters: &[Option<f64>], of_group: &[usize]) -> Vec<Method> {
    let method = |m: usize| {
        let trials = advice.trials.iter().zip(scatters).filter(|(trial, _)| trial.method == m);
        let run =
            |(trial, scatter): (&Trial, &Option<f64>)| run_of(advice, of_group, trial, *scatter);
        let runs: Vec<Run> = trials.filter_map(run).collect();
        let ladder = &advice.ladder.methods[m];
        let unit = match ladder.growth {
            Growth::Lattice { .. } => " (lattice)",
            Growth::Samples => " (samples)",
            Growth::Fixed => "",
        };
        (!runs.is_empty()).then(|| Method { name: format!("{}{unit}", ladder.name), runs })
    };
    if of_group.is_empty() {
        return Vec::new();
    }
    (0..advice.ladder.methods.len()).filter_map(method).collect()
}

fn run_of(advice: &Advice, of_group: &[usize], trial: &Trial, scatter: Option<f64>) -> Option<Run> {
    // A failed run has no cost.
    let answers = trial.answers()?;
    let error = |&q: &usize| advice.judgements[q].error_of(trial);
    // A method without any of these quantities is not on this chart.
    of_group.iter().find_map(error)?;
    let errors: Option<Vec<f64>> = of_group.iter().map(error).collect();
    let largest = errors.map(|errors| errors.into_iter().fold(0.0, f64::max));
    let outcome = match largest.filter(|largest| largest.is_finite()) {
        Some(value) if value > 0.0 => RunOutcome::Error { value, standard_error: None },
        _ => RunOutcome::Failed { reason: "a quantity is missing".into() },
    };
    let label = match advice.ladder.methods[trial.method].growth {
        Growth::Fixed => None,
        Growth::Lattice { .. } | Growth::Samples => Some(short_label(&trial.rung.label)),
    };
    Some(run((answers.cpu_seconds, scatter.unwrap_or(0.0)), outcome, label))
}

/// Label without the noun, which is in the legend.
fn short_label(label: &str) -> String {
    let mut words = label.split(' ');
    match (words.next(), words.next(), words.next()) {
        (Some(number), Some(_), None) if number.parse::<f64>().is_ok() => number.to_owned(),
        (Some(_), Some(number), None) => number.to_owned(),
        _ => label.to_owned(),
    }
}
