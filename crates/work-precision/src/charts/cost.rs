//! What all charts of error against cost share: measured CPU time, outcomes, and the rows printed below a chart.

use std::time::Duration;

use result_figures::{Measure, Method, Reading, Run, RunOutcome};
use scenes::clock::CpuClock;

use reference_problems::context::CaseError;

/// CPU time above which a run is not repeated.
pub(super) const LONG: Duration = Duration::from_secs(3);

/// CPU seconds across.
pub(super) fn cost_in_seconds(errors: Measure, reference_error: f64) -> Reading {
    Reading::Cost { unit: "s".into(), errors, reference_error }
}

/// The result with its median CPU time and half the range; three runs if one is short.
pub(super) fn timed<T>(
    long: Duration,
    mut work: impl FnMut() -> Result<T, CaseError>,
) -> Result<(T, f64, f64), CaseError> {
    let mut measure = || -> Result<(T, f64), CaseError> {
        let start = CpuClock::start();
        let result = work()?;
        Ok((result, start.seconds()))
    };
    let (result, first) = measure()?;
    let mut costs = vec![first];
    if first < long.as_secs_f64() {
        for _ in 0..2 {
            costs.push(measure()?.1);
        }
    }
    let (median, spread) = median_and_half_range(costs);
    Ok((result, median, spread))
}

/// The median of some costs, and half their range.
pub(super) fn median_and_half_range(mut costs: Vec<f64>) -> (f64, f64) {
    costs.sort_by(f64::total_cmp);
    (costs[costs.len() / 2], 0.5 * (costs[costs.len() - 1] - costs[0]))
}

/// A run with its cost; a cost without scatter has no bar.
pub(super) fn run((cost, scatter): (f64, f64), outcome: RunOutcome, label: Option<String>) -> Run {
    Run { cost, cost_error: (scatter > 0.0).then_some(scatter), outcome, label }
}

/// An error without a standard error. A logarithmic axis cannot show an error of zero.
pub(super) fn outcome(error: f64) -> RunOutcome {
    if error > 0.0 && error.is_finite() {
        RunOutcome::Error { value: error, standard_error: None }
    } else {
        RunOutcome::Failed { reason: format!("error {error}") }
    }
}

/// Cost and error of every run.
pub(super) fn table(series: &[Method]) -> String {
    let line = |method: &Method, run: &Run| {
        let label = run.label.as_deref().map_or_else(String::new, |label| format!(", {label}"));
        let error = match &run.outcome {
            RunOutcome::Error { value, standard_error: Some(bar) } => {
                format!("{value:.1e} +- {bar:.0e}")
            }
            RunOutcome::Error { value, standard_error: None } => format!("{value:.1e}"),
            RunOutcome::Failed { reason } => reason.clone(),
        };
        format!("  {:10.4}  {error:18}  {}{label}", run.cost, method.name)
    };
    let lines = series.iter().flat_map(|method| method.runs.iter().map(move |r| line(method, r)));
    lines.collect::<Vec<_>>().join("\n")
}

/// Formats 12345 as `12,345`.
pub(super) fn group_thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped() {
        let grouped = [7, 123, 1_000, 1_234_567].map(group_thousands);
        assert_eq!(grouped, ["7", "123", "1,000", "1,234,567"]);
    }
}
