//! Table of the cheapest method for a tolerance.

use result_figures::markdown::{table, text};
use result_figures::{Drawing, DrawingError, settled};
use scenes::machine::{Machine, date};
use serde::Serialize;

use super::records::{Outcome, Record, Scene, methods};

/// Relative tolerances of the table.
const TOLERANCES: [f64; 5] = [0.1, 0.03, 0.01, 0.003, 0.001];

/// Cost of a method for a tolerance.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Cost {
    method: String,
    cpu_seconds: f64,
    /// Whether the cost is extrapolated by the inverse square root and was not measured.
    projected: bool,
}

/// One quantity with all runs and the choice.
#[derive(Debug, Serialize)]
struct Choice<'a> {
    scene: &'a str,
    quantity: &'a str,
    title: &'a str,
    reference_error: f64,
    /// For each tolerance all methods that reach it, cheapest first; nothing below the error of the reference.
    by_tolerance: Vec<(f64, Vec<Cost>)>,
    records: Vec<&'a Record>,
}

/// All records.
#[derive(Debug, Serialize)]
struct Recorded<'a> {
    date: Option<String>,
    machine: Machine,
    choices: Vec<Choice<'a>>,
}

/// Cost of a method for a tolerance.
///
/// For a deterministic method it is that of the cheapest run from which all finer runs are within the tolerance, so an
/// error that happens to cross zero does not count. For a sampled method it is extrapolated from the longest run by
/// the inverse square root, and is at least the cost of its shortest run.
fn cost(records: &[&Record], tolerance: f64) -> Option<Cost> {
    let mut runs: Vec<&Record> =
        records.iter().copied().filter(|record| record.error().is_some()).collect();
    runs.sort_by(|a, b| a.cpu_seconds.total_cmp(&b.cpu_seconds));
    let last = *runs.last()?;
    let method = last.method.clone();
    if let Outcome::Sampled { predicted, .. } = last.outcome {
        let scaled = last.cpu_seconds * (predicted / tolerance).powi(2);
        let cpu_seconds = scaled.max(runs[0].cpu_seconds);
        return Some(Cost { method, cpu_seconds, projected: cpu_seconds > last.cpu_seconds });
    }
    let within = |record: &Record| record.error().is_some_and(|error| error <= tolerance);
    let first = settled(runs, |record| record.cpu_seconds, within)?;
    Some(Cost { method, cpu_seconds: first.cpu_seconds, projected: false })
}

fn choices(scenes: &[Scene]) -> Vec<Choice<'_>> {
    let mut choices = Vec::new();
    for scene in scenes {
        for quantity in &scene.quantities {
            let records: Vec<&Record> =
                scene.records.iter().filter(|r| r.quantity == quantity.name).collect();
            let names = methods(records.iter().copied());
            let costs = |tolerance: f64| {
                if tolerance < quantity.reference_error {
                    return Vec::new();
                }
                let of = |name: &&str| {
                    let of_method: Vec<&Record> =
                        records.iter().copied().filter(|r| r.method == *name).collect();
                    cost(&of_method, tolerance)
                };
                let mut costs: Vec<Cost> = names.iter().filter_map(of).collect();
                costs.sort_by(|a, b| a.cpu_seconds.total_cmp(&b.cpu_seconds));
                costs
            };
            choices.push(Choice {
                scene: scene.title,
                quantity: quantity.name,
                title: &quantity.title,
                reference_error: quantity.reference_error,
                by_tolerance: TOLERANCES.map(|tolerance| (tolerance, costs(tolerance))).to_vec(),
                records,
            });
        }
    }
    choices
}

/// The table as a page, with all records as its data.
pub(super) fn page(scenes: &[Scene]) -> Result<Drawing, DrawingError> {
    let recorded = Recorded { date: date(), machine: Machine::read(), choices: choices(scenes) };
    Drawing::page("fpk-choice", markdown(&recorded), &recorded)
}

fn markdown(recorded: &Recorded<'_>) -> String {
    let date = recorded.date.as_deref().unwrap_or("date unknown");
    let mut lines = vec![
        "# The cheapest method for a tolerance".to_owned(),
        String::new(),
        format!("Written by `cargo xtask chart fpk`; {date}, {}.", recorded.machine.caption()),
        String::new(),
        "Each cell: the cheapest method and its CPU seconds on one thread; in brackets those of the particles, if they \
         are not the cheapest (– if none of their runs reached the tolerance). \
         The error is relative. For sampled methods it is one standard error, without the bias of their time steps. Their \
         cost is extrapolated by the inverse square root from the longest run; a cost with * was not run. \
         A deterministic method counts from the run from which all finer ones are within the tolerance. Its error is \
         known here from a reference; a sampled method estimates its own. \
         There is no entry below the error of the reference. The pictures and `fpk-choice.json` contain every run."
            .to_owned(),
    ];
    let heads: Vec<String> = std::iter::once("question".to_owned())
        .chain(TOLERANCES.iter().map(|tolerance| format!("{} %", 100.0 * tolerance)))
        .collect();
    for of_scene in recorded.choices.chunk_by(|a, b| a.scene == b.scene) {
        let row = |choice: &Choice<'_>| {
            let cells = choice.by_tolerance.iter().map(|(_, costs)| cell(costs));
            std::iter::once(text(choice.title)).chain(cells).collect()
        };
        let rows: Vec<Vec<String>> = of_scene.iter().map(row).collect();
        let scene = of_scene.first().map_or("", |choice| choice.scene);
        lines.push(format!("\n## {scene}\n\n{}", table(&heads, &rows).trim_end()));
    }
    lines.push(String::new());
    lines.join("\n")
}

fn cell(costs: &[Cost]) -> String {
    let Some(best) = costs.first() else { return String::new() };
    let seconds = |cost: &Cost| {
        let star = if cost.projected { "*" } else { "" };
        format!("{}{star}", two_digits(cost.cpu_seconds))
    };
    let particles = costs.iter().find(|cost| cost.method.starts_with("particles"));
    let beside = match particles {
        Some(cost) if cost.method == best.method => String::new(),
        Some(cost) => format!(" ({})", seconds(cost)),
        None => " (–)".to_owned(),
    };
    format!("{} {}{beside}", best.method, seconds(best))
}

/// Formats two digits without an exponent.
fn two_digits(value: f64) -> String {
    if value >= 10.0 {
        return format!("{value:.0}");
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 12")]
    let decimals = (1.0 - value.max(1e-12).log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(method: &str, cpu_seconds: f64, outcome: Outcome) -> Record {
        Record {
            quantity: "moments".into(),
            method: method.into(),
            label: String::new(),
            cpu_seconds,
            cpu_spread: 0.0,
            outcome,
        }
    }

    #[test]
    fn an_error_that_crosses_zero_does_not_count() {
        let off = |cost, error| record("grid", cost, Outcome::Off { error });
        let runs = [off(1.0, 0.05), off(2.0, 1e-5), off(4.0, 0.02), off(8.0, 0.004)];
        let runs: Vec<&Record> = runs.iter().collect();
        let seconds = |tolerance| cost(&runs, tolerance).map(|cost| cost.cpu_seconds);
        assert_eq!(seconds(0.1), Some(1.0));
        assert_eq!(seconds(0.03), Some(2.0));
        assert_eq!(seconds(0.01), Some(8.0));
        assert_eq!(seconds(0.001), None);
    }

    #[test]
    fn a_sampled_method_costs_by_the_inverse_root_and_not_below_its_shortest_run() {
        let drawn = |cost, predicted| {
            record(
                "Monte Carlo",
                cost,
                Outcome::Sampled { predicted, uncertainty: None, seen: None },
            )
        };
        let nothing = record("Monte Carlo", 0.01, Outcome::Nothing { reason: "none".into() });
        let runs = [nothing, drawn(0.1, 0.1), drawn(1.0, 0.03)];
        let runs: Vec<&Record> = runs.iter().collect();
        let at = |tolerance| cost(&runs, tolerance).unwrap();
        assert!((at(0.01).cpu_seconds - 9.0).abs() < 1e-12 && at(0.01).projected);
        assert!((at(0.3).cpu_seconds - 0.1).abs() < 1e-12 && !at(0.3).projected);
    }

    #[test]
    fn costs_are_written_with_two_digits() {
        let written = [0.00123, 0.0951, 0.5, 3.16, 31.4, 12345.0].map(two_digits);
        assert_eq!(written, ["0.0012", "0.095", "0.50", "3.2", "31", "12345"]);
    }
}
