//! What the page shows of a result of the schema `run-result/1`: densities and tail probabilities.

use std::collections::BTreeMap;

use result_figures::number::{counted, percent, short};
use result_pages::{Cell, Chart, Note, Point, Series as Line, Source, below};
use scene_runs::answers::{ErrorOrigin, Unknown};
use scene_runs::report::{Report, chart, method_words, number_cells, table};
use serde::Serialize;

use super::observed::{Observed, WeightsRecord};
use super::record::{Content, Probability, Quantity, Series};

/// Heading of the chart of an estimator.
const fn title(by: Probability) -> &'static str {
    match by {
        Probability::FirstPassage => "Probability of first passage over time",
        Probability::Cell => "Probability of exceedance, integrated over cells over time",
        Probability::LogInterpolated => {
            "Probability of exceedance, interpolated between particles over time"
        }
        Probability::Exceedance => "Probability of exceedance over time",
        Probability::Indicator => "Probability of exceedance, masses counted over time",
    }
}

impl Series {
    /// The upper bound of a value in place of it: of probabilities alone, which are not negative.
    fn bound(&self, value: &Observed) -> Option<f64> {
        self.of.estimator().and_then(|_| value.number().upper_bound())
    }

    fn line(&self) -> Line {
        let point = |it: &Observed| Point { bound: self.bound(it), ..it.number().point(it.t) };
        Line { name: self.quantity.clone(), points: self.values.iter().map(point).collect() }
    }

    fn rows(&self, from: usize) -> impl Iterator<Item = Vec<Cell>> {
        self.values[from..].iter().map(|it| {
            let [value, error] = match self.bound(it) {
                Some(bound) => [Cell::number(below(bound), bound), Cell::text("")],
                None => number_cells(&it.number()),
            };
            vec![
                Cell::text(&self.quantity),
                Cell::text(self.of.to_string()),
                Cell::number(it.t.to_string(), it.t),
                value,
                error,
                Cell::text(it.error_kind.words()),
                Cell::text(it.note.clone().unwrap_or_default()),
            ]
        })
    }
}

/// What the page shows of a result of the schema `run-result/1`.
pub(crate) fn report(content: &Content, method: &impl Serialize, sources: &[Source]) -> Report {
    let mut report = Report { sources: sources.to_vec(), ..Report::default() };
    notes(content, &mut report);
    charts(content, &mut report);
    tables(content, &mut report);
    report.fact("method", method_words(method));
    facts(content, &mut report);
    report
}

fn notes(content: &Content, report: &mut Report) {
    if let Some(reason) = &content.stopped {
        let text = format!("the run ended before its last time: {reason}");
        report.notes.push(Note::Warning(text));
    }
    report.notes.extend(content.unknown.iter().map(Unknown::note));
    // Notes that differ in their numbers alone are one, with the first as an example.
    let mut alike: BTreeMap<String, (&str, usize)> = BTreeMap::new();
    for note in
        content.quantities.iter().flat_map(|it| &it.values).filter_map(|it| it.note.as_deref())
    {
        let words: String = note.chars().filter(|c| c.is_alphabetic() || *c == ' ').collect();
        alike.entry(words).or_insert((note, 0)).1 += 1;
    }
    let note = |(text, n): (&str, usize)| match n {
        1 => Note::Remark(format!("1 value: {text}")),
        _ => Note::Remark(format!("{n} values, the first: {text}")),
    };
    report.notes.extend(alike.into_values().map(note));
}

/// A chart for each group of probabilities, and one for the moments of each order.
fn charts(content: &Content, report: &mut Report) {
    let over_time = |title: String, label: &str, series: &[&Series]| {
        let labels = ["time (s)".to_owned(), label.to_owned()];
        chart(title, labels, series.iter().map(|it| it.line()).collect())
    };
    for by in Probability::ALL {
        let series: Vec<&Series> =
            content.quantities.iter().filter(|it| it.of.estimator() == Some(by)).collect();
        if series.iter().any(|it| it.values.len() > 1) {
            let chart = over_time(title(by).to_owned(), "probability", &series);
            report.charts.push(Chart { is_logarithmic: true, ..chart });
        }
    }
    let mut orders: BTreeMap<u32, Vec<&Series>> = BTreeMap::new();
    for series in &content.quantities {
        if let Quantity::Moment(powers) = &series.of {
            orders.entry(powers.iter().sum()).or_default().push(series);
        }
    }
    for (order, series) in orders {
        if series.iter().any(|it| it.values.len() > 1) {
            let label = format!("moment of order {order}");
            let title = format!("Moments of order {order} over time");
            report.charts.push(over_time(title, &label, &series));
        }
    }
}

fn tables(content: &Content, report: &mut Report) {
    let heads = ["quantity", "id", "time (s)", "value", "error", "how the error is known", "note"];
    let all = content.quantities.iter().flat_map(|it| it.rows(0)).collect();
    let last = content.quantities.iter().flat_map(|it| it.rows(it.values.len().saturating_sub(1)));
    report.table_over_time(
        table("All values", &heads, all),
        table("Values at the last time", &heads, last.collect()),
    );
}

fn facts(content: &Content, report: &mut Report) {
    if let Some(seed) = content.seed {
        report.fact("seed", seed.to_string());
    }
    report.counts(&content.work);
    let last = || content.quantities.iter().filter_map(|it| Some((it, it.values.last()?)));
    let by_two: Vec<(f64, &Quantity)> = last()
        .filter(|(_, it)| it.error_kind == ErrorOrigin::TwoResolutions && it.value != 0.0)
        .filter_map(|(series, it)| Some((it.error? / it.value.abs(), &series.of)))
        .collect();
    if let Some((worst, of)) = by_two.iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
        report.fact(
            "resolutions",
            format!(
                "errors of {} come from coarser runs; the largest relative one at the last time is {} ({of})",
                counted(by_two.len(), "quantity").replace("quantitys", "quantities"),
                percent(*worst)
            ),
        );
    }
    let weights: Vec<&WeightsRecord> = last().filter_map(|(_, it)| it.weights.as_ref()).collect();
    if let Some(least) = weights.iter().map(|it| it.effective_sample_size).reduce(f64::min) {
        let share = weights.iter().map(|it| it.largest_share).fold(0.0, f64::max);
        report.fact(
            "effective sample size",
            format!(
                "at least {} at the last time; the largest share of one path is {}",
                short(Some(least)),
                percent(share)
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_that_no_particle_carries_is_a_bound_on_table_and_chart() {
        let first = Observed::by_two(1.0, 0.5, Some(0.01));
        let mut small = Observed::by_two(2.0, 1.7e-7, Some(1e-9));
        small.bounded_by(2.5e-7);
        let of = Quantity::Probability { by: Probability::Cell, threshold: 2.0 };
        let (quantity, values) = ("P(|q| > 2)".to_owned(), vec![first, small]);
        let tail = Series { of, quantity, unit: String::new(), values };
        let points = tail.line().points;
        assert_eq!((points[0].bound, points[1].bound), (None, Some(1.7e-7 + 2.5e-7)));
        let row = tail.rows(1).next().unwrap();
        let cells: Vec<&str> = row.iter().map(|cell| cell.text.as_str()).collect();
        assert_eq!(cells[3..5], ["< 4.2e-7", ""]);
        // A covariance may have either sign: its bound is one of the error.
        let of = Quantity::Moment(vec![1, 1]);
        let covariance = Series { of, ..tail };
        assert_eq!(covariance.line().points[1].bound, None);
    }
}
