//! The cheapest method for a tolerance, read from a chart of error against cost.

use serde::{Deserialize, Serialize};

use crate::data::{Measure, Method, Reading, Run, RunOutcome, WorkPrecision};
use crate::markdown;
use crate::number;

/// The tolerances: 10 %, 1 %, 0.1 %.
const TOLERANCES: [f64; 3] = [0.1, 0.01, 0.001];

/// A tolerance and the cheapest method for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// The tolerance in words, e.g. `10 %`.
    pub tolerance: String,
    /// The largest error within the tolerance, on the vertical axis of the chart.
    pub within: f64,
    /// Which method is the cheapest.
    pub verdict: Verdict,
}

/// Which method is the cheapest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Verdict {
    /// A method reached the tolerance.
    Reached {
        /// The cheapest method.
        cheapest: Candidate,
        /// The next cheapest method.
        runner_up: Option<Candidate>,
    },
    /// No method reached the tolerance.
    NotReached {
        /// The run with the smallest error.
        nearest: Option<Candidate>,
    },
    /// The reference is less accurate than the tolerance.
    ReferenceTooRough,
}

/// The run that represents a method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// The method.
    pub method: String,
    /// Parameter of the run.
    pub label: Option<String>,
    /// Its cost, in the unit of the chart.
    pub cost: f64,
    /// Scatter of the cost.
    pub cost_error: Option<f64>,
    /// Its error plus the standard error of that error.
    pub error: f64,
}

/// The cheapest run from which all more expensive runs are within a tolerance.
///
/// So an error that happens to cross zero does not count.
pub fn settled<'r, R>(
    runs: impl IntoIterator<Item = &'r R>,
    cost: impl Fn(&R) -> f64,
    is_within: impl Fn(&R) -> bool,
) -> Option<&'r R> {
    let mut runs: Vec<&R> = runs.into_iter().collect();
    runs.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    runs.into_iter().rev().take_while(|run| is_within(run)).last()
}

/// The cheapest method for each tolerance; empty where the horizontal axis is no cost.
///
/// A run is within a tolerance if the sum of its error and standard error is. Runs without a result are ignored.
#[must_use]
pub fn choices(chart: &WorkPrecision) -> Vec<Choice> {
    let Reading::Cost { errors, reference_error, .. } = &chart.reading else { return Vec::new() };
    let choice = |tolerance: f64| {
        let within = errors.of(tolerance);
        let verdict = if *reference_error > within {
            Verdict::ReferenceTooRough
        } else {
            verdict(&chart.series, within)
        };
        Choice { tolerance: errors.words(tolerance), within, verdict }
    };
    TOLERANCES.map(choice).to_vec()
}

fn verdict(series: &[Method], within: f64) -> Verdict {
    let mut reached: Vec<Candidate> = series
        .iter()
        .filter_map(|method| {
            let runs = method.runs.iter().filter(|run| bound(run).is_some());
            let is_within = |run: &Run| bound(run).is_some_and(|error| error <= within);
            candidate(method, settled(runs, |run| run.cost, is_within)?)
        })
        .collect();
    reached.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut reached = reached.into_iter();
    match reached.next() {
        Some(cheapest) => Verdict::Reached { cheapest, runner_up: reached.next() },
        None => Verdict::NotReached { nearest: nearest(series) },
    }
}

fn nearest(series: &[Method]) -> Option<Candidate> {
    let runs = series.iter().flat_map(|method| method.runs.iter().map(move |run| (method, run)));
    let candidates = runs.filter_map(|(method, run)| candidate(method, run));
    candidates.min_by(|a, b| a.error.total_cmp(&b.error))
}

fn candidate(method: &Method, run: &Run) -> Option<Candidate> {
    Some(Candidate {
        method: method.name.clone(),
        label: run.label.clone(),
        cost: run.cost,
        cost_error: run.cost_error,
        error: bound(run)?,
    })
}

/// The error plus its standard error.
fn bound(run: &Run) -> Option<f64> {
    match run.outcome {
        RunOutcome::Error { value, standard_error } => Some(value + standard_error.unwrap_or(0.0)),
        RunOutcome::Failed { .. } => None,
    }
}

impl Measure {
    /// A relative tolerance in this measure; for absolute errors the number itself.
    fn of(self, tolerance: f64) -> f64 {
        match self {
            Self::Relative | Self::Absolute => tolerance,
            // A result too low by the same factor is slightly further away.
            Self::Log10 => (1.0 + tolerance).log10(),
        }
    }

    fn words(self, tolerance: f64) -> String {
        match self {
            Self::Relative => format!("{} %", 100.0 * tolerance),
            Self::Log10 => format!(
                "{} % ({} in log10)",
                100.0 * tolerance,
                number::short(Some(self.of(tolerance)))
            ),
            Self::Absolute => format!("{tolerance}"),
        }
    }
}

/// The choices as a Markdown table with costs in the unit of the chart; empty without choices.
#[must_use]
pub fn choices_table(choices: &[Choice], reading: &Reading) -> String {
    let Reading::Cost { unit, .. } = reading else { return String::new() };
    let cost = format!("CPU ({unit})");
    let heads = ["error within", "cheapest", &cost, "runner-up", &cost].map(str::to_owned);
    let rows: Vec<Vec<String>> = choices.iter().map(row).collect();
    markdown::table(&heads, &rows)
}

fn row(choice: &Choice) -> Vec<String> {
    let none = || ["none".to_owned(), String::new()];
    let (cheapest, runner_up) = match &choice.verdict {
        Verdict::Reached { cheapest, runner_up } => {
            (cells(cheapest), runner_up.as_ref().map_or_else(none, cells))
        }
        Verdict::NotReached { nearest } => {
            let nearest = nearest.as_ref().map_or_else(String::new, |nearest| {
                let (error, name) = (number::short(Some(nearest.error)), name(nearest));
                format!("; nearest {error} by {name}")
            });
            ([format!("none reached it{nearest}"), String::new()], Default::default())
        }
        Verdict::ReferenceTooRough => {
            (["the reference is not known so well".to_owned(), String::new()], Default::default())
        }
    };
    [vec![choice.tolerance.clone()], cheapest.to_vec(), runner_up.to_vec()].concat()
}

fn name(candidate: &Candidate) -> String {
    let label = candidate.label.as_ref().map_or_else(String::new, |label| format!(", {label}"));
    markdown::text(&format!("{}{label}", candidate.method))
}

fn cells(candidate: &Candidate) -> [String; 2] {
    let scatter =
        candidate.cost_error.map_or_else(String::new, |scatter| format!(" ± {scatter:.0e}"));
    [name(candidate), format!("{}{scatter}", number::short(Some(candidate.cost)))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    fn reading(errors: Measure, reference_error: f64) -> Reading {
        Reading::Cost { unit: "s".into(), errors, reference_error }
    }

    /// The sample chart with its errors read as relative errors.
    fn sample() -> WorkPrecision {
        let reading = reading(Measure::Relative, 0.0);
        WorkPrecision { reading, ..samples::work_precision() }
    }

    fn names(verdict: &Verdict) -> (String, Option<String>) {
        let label = |of: &Candidate| format!("{}, {}", of.method, of.label.clone().unwrap());
        match verdict {
            Verdict::Reached { cheapest, runner_up } => {
                (label(cheapest), runner_up.as_ref().map(label))
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_cheapest_run_and_that_of_another_method_are_found() {
        let choices = choices(&sample());
        let (cheapest, runner_up) = names(&choices[0].verdict);
        assert_eq!(cheapest, "log-density fit, whitened, RK4, 400");
        assert_eq!(
            runner_up.unwrap(),
            "summation density, isotropic, forward Euler (the paper's), 400"
        );
        let (cheapest, runner_up) = names(&choices[1].verdict);
        assert_eq!(cheapest, "log-density fit, whitened, RK4, 1,700");
        assert_eq!(runner_up.unwrap(), "Monte Carlo, Strang, 10⁷");
    }

    #[test]
    fn the_standard_error_counts() {
        // Strang with 10^7 paths is within 1 % for an error of 0.003 with standard error 0.001, but not with 0.008.
        let mut chart = sample();
        let run = chart.series.last_mut().unwrap().runs.last_mut().unwrap();
        run.outcome = RunOutcome::Error { value: 0.003, standard_error: Some(0.008) };
        let (_, runner_up) = names(&choices(&chart)[1].verdict);
        assert_eq!(runner_up, None);
    }

    #[test]
    fn what_no_method_reached_is_said_with_the_nearest() {
        let choices = choices(&{
            let mut chart = sample();
            chart.series.remove(0);
            chart
        });
        let Verdict::NotReached { nearest: Some(nearest) } = &choices[2].verdict else {
            panic!("{:?}", choices[2])
        };
        assert!((nearest.error - 0.004).abs() < 1e-12, "{nearest:?}");
        let table = choices_table(&choices, &sample().reading);
        let line = table.lines().last().unwrap();
        assert!(
            line.contains("none reached it; nearest 0.00400 by Monte Carlo, Strang, 10⁷"),
            "{table}"
        );
    }

    #[test]
    fn an_error_that_crosses_zero_does_not_count() {
        let runs = [(1.0, 0.05), (2.0, 1e-5), (4.0, 0.02), (8.0, 0.004)];
        let first = |tolerance: f64| settled(&runs, |run| run.0, |run| run.1 <= tolerance);
        assert_eq!(first(0.1), Some(&runs[0]));
        assert_eq!(first(0.03), Some(&runs[1]));
        assert_eq!(first(0.01), Some(&runs[3]));
        assert_eq!(first(0.001), None);
    }

    #[test]
    fn nothing_is_chosen_below_the_error_of_the_reference_or_without_a_cost() {
        let mut chart = sample();
        chart.reading = reading(Measure::Relative, 0.002);
        let verdicts: Vec<Verdict> = choices(&chart).into_iter().map(|c| c.verdict).collect();
        assert!(matches!(verdicts[1], Verdict::Reached { .. }));
        assert_eq!(verdicts[2], Verdict::ReferenceTooRough);
        chart.reading = Reading::Parameter;
        assert_eq!(choices(&chart), []);
        assert_eq!(choices_table(&[], &chart.reading), "");
    }

    #[test]
    fn a_tolerance_is_told_in_the_measure_of_the_chart() {
        let head = |measure| {
            let reading = reading(measure, 0.0);
            choices(&WorkPrecision { reading, ..sample() }).remove(0)
        };
        assert_eq!(head(Measure::Relative).tolerance, "10 %");
        assert_eq!(head(Measure::Absolute).tolerance, "0.1");
        let logarithmic = head(Measure::Log10);
        assert_eq!(logarithmic.tolerance, "10 % (0.0414 in log10)");
        assert!((logarithmic.within - 1.1_f64.log10()).abs() < 1e-15);
    }
}
