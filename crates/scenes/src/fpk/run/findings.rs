//! What a run of the schema `run-result/1` found: densities and tail probabilities.

use std::collections::BTreeMap;

use result_figures::number::{counted, percent, short};
use result_pages::{Answer, Cell, Chart, Note, Point, Series, Source, Table, below};
use serde::Deserialize;
use serde_json::Value;

use crate::findings::sources::{
    AU_BECK_2001, CANOR_2013, GIRSANOV_1960, MACKE_2003, ROBERTS_1990, SCHARFETTER_1969,
};
use crate::findings::{Findings, ReadUnknown, cell, how, method_words, short_cell};

#[derive(Debug, Deserialize)]
struct Read {
    scene: Value,
    seed: Option<u64>,
    work: Value,
    stopped: Option<String>,
    unknown: Vec<ReadUnknown>,
    quantities: Vec<ReadSeries>,
}

#[derive(Debug, Deserialize)]
struct ReadSeries {
    id: String,
    quantity: String,
    unit: String,
    values: Vec<ReadValue>,
}

#[derive(Debug, Deserialize)]
struct ReadValue {
    t: f64,
    value: f64,
    error: Option<f64>,
    error_kind: String,
    note: Option<String>,
    weights: Option<ReadWeights>,
}

#[derive(Debug, Deserialize)]
struct ReadWeights {
    effective_sample_size: f64,
    largest_share: f64,
}

/// Groups of probabilities, the best estimator first.
const PROBABILITIES: [(&str, &str); 5] = [
    ("first-passage", "Probability of first passage"),
    ("exceedance-cell", "Probability of exceedance, integrated over cells"),
    ("exceedance-log-interpolated", "Probability of exceedance, interpolated between particles"),
    ("exceedance", "Probability of exceedance"),
    ("exceedance-indicator", "Probability of exceedance, masses counted"),
];
/// Probabilities, and moments, among the answers.
const FIRST: usize = 3;

impl ReadValue {
    /// The upper bound of a probability of which no more is known.
    fn bound(&self) -> Option<f64> {
        let error = self.error.filter(|&error| error >= self.value)?;
        let bound = self.value + error;
        (self.error_kind == "bound" && bound > 0.0).then_some(bound)
    }
}

impl ReadSeries {
    fn group(&self) -> &str {
        self.id.split('/').next().unwrap_or_default()
    }

    /// The upper bound of a value in place of it: of probabilities alone, which are not negative.
    fn bound(&self, value: &ReadValue) -> Option<f64> {
        PROBABILITIES.iter().any(|(group, _)| *group == self.group()).then(|| value.bound())?
    }

    /// Sum of the powers of a moment.
    fn order(&self) -> Option<u32> {
        let (_, powers) = self.id.split_once("moment/")?;
        powers.split('-').map(|power| power.parse::<u32>().ok()).sum()
    }

    fn answer(&self) -> Option<Answer> {
        let last = self.values.last()?;
        Some(Answer {
            quantity: self.quantity.clone(),
            at: format!("t = {} s", last.t),
            value: last.value,
            error: last.error,
            bound: self.bound(last),
            unit: self.unit.clone(),
            how: how(&last.error_kind),
        })
    }

    fn line(&self) -> Series {
        let point = |it: &ReadValue| Point {
            x: it.t,
            y: it.value,
            error: it.error,
            bound: self.bound(it),
            how: how(&it.error_kind),
            spread: None,
        };
        Series { name: self.quantity.clone(), points: self.values.iter().map(point).collect() }
    }

    fn rows(&self, from: usize) -> impl Iterator<Item = Vec<Cell>> {
        self.values[from..].iter().map(|it| {
            let [value, error] = match self.bound(it) {
                Some(bound) => [Cell::number(below(bound), bound), Cell::text("")],
                None => [cell(Some(it.value)), short_cell(it.error)],
            };
            vec![
                Cell::text(&self.quantity),
                Cell::text(self.id.clone()),
                Cell::number(it.t.to_string(), it.t),
                value,
                error,
                Cell::text(how(&it.error_kind)),
                Cell::text(it.note.clone().unwrap_or_default()),
            ]
        })
    }
}

/// Reads the findings from a result.
pub(crate) fn findings(result: &Value) -> Result<Findings, serde_json::Error> {
    let read = Read::deserialize(result)?;
    let mut findings = Findings::default();
    let probabilities = PROBABILITIES
        .iter()
        .find(|(group, _)| read.quantities.iter().any(|it| it.group() == *group))
        .map_or("", |(group, _)| group);
    let of_group = |group: &'static str| {
        read.quantities.iter().filter(move |it| it.group() == group).filter_map(ReadSeries::answer)
    };
    let (tails, moments) = (of_group(probabilities).count(), of_group("moment").count());
    let n_tails = FIRST.max((2 * FIRST).saturating_sub(moments));
    let n_moments = FIRST.max((2 * FIRST).saturating_sub(tails));
    findings.answers.extend(of_group(probabilities).take(n_tails));
    findings.answers.extend(of_group("moment").take(n_moments));
    let n_values: usize = read.quantities.iter().map(|it| it.values.len()).sum();
    findings.n_more = n_values.saturating_sub(findings.answers.len());
    notes(&read, &mut findings);
    charts(&read, &mut findings);
    tables(&read, &mut findings);
    facts(&read, &mut findings);
    findings.sources = sources(&read.scene);
    Ok(findings)
}

fn notes(read: &Read, findings: &mut Findings) {
    if let Some(reason) = &read.stopped {
        let text = format!("the run ended before its last time: {reason}");
        findings.notes.push(Note::Warning(text));
    }
    findings.notes.extend(read.unknown.iter().map(ReadUnknown::note));
    // Notes that differ in their numbers alone are one, with the first as an example.
    let mut alike: BTreeMap<String, (&str, usize)> = BTreeMap::new();
    for note in read.quantities.iter().flat_map(|it| &it.values).filter_map(|it| it.note.as_deref())
    {
        let words: String = note.chars().filter(|c| c.is_alphabetic() || *c == ' ').collect();
        alike.entry(words).or_insert((note, 0)).1 += 1;
    }
    let note = |(text, n): (&str, usize)| match n {
        1 => Note::Remark(format!("1 value: {text}")),
        _ => Note::Remark(format!("{n} values, the first: {text}")),
    };
    findings.notes.extend(alike.into_values().map(note));
    findings.note_order_of_magnitude();
    findings.note_unknown_errors();
}

/// A chart for each group of probabilities, and one for the moments of each order.
fn charts(read: &Read, findings: &mut Findings) {
    let chart =
        |title: String, y_label: &str, is_logarithmic: bool, series: Vec<&ReadSeries>| Chart {
            title,
            x_label: "time (s)".to_owned(),
            y_label: y_label.to_owned(),
            is_logarithmic,

            x_is_logarithmic: false,
            spread: String::new(),
            series: series.into_iter().map(ReadSeries::line).collect(),
        };
    for (group, title) in PROBABILITIES {
        let series: Vec<&ReadSeries> =
            read.quantities.iter().filter(|it| it.group() == group).collect();
        if series.iter().any(|it| it.values.len() > 1) {
            findings.charts.push(chart(format!("{title} over time"), "probability", true, series));
        }
    }
    let mut orders: BTreeMap<u32, Vec<&ReadSeries>> = BTreeMap::new();
    for series in &read.quantities {
        if let Some(order) = series.order() {
            orders.entry(order).or_default().push(series);
        }
    }
    for (order, series) in orders {
        if series.iter().any(|it| it.values.len() > 1) {
            let label = format!("moment of order {order}");
            findings.charts.push(chart(
                format!("Moments of order {order} over time"),
                &label,
                false,
                series,
            ));
        }
    }
}

fn tables(read: &Read, findings: &mut Findings) {
    let heads = ["quantity", "id", "time (s)", "value", "error", "how the error is known", "note"];
    let table = |title: &str, rows: Vec<Vec<Cell>>| Table {
        title: title.to_owned(),
        about: String::new(),
        heads: heads.map(str::to_owned).to_vec(),
        rows,
    };
    let all = read.quantities.iter().flat_map(|it| it.rows(0)).collect();
    let last = read.quantities.iter().flat_map(|it| it.rows(it.values.len().saturating_sub(1)));
    findings.table_over_time(
        table("All values", all),
        table("Values at the last time", last.collect()),
    );
}

fn facts(read: &Read, findings: &mut Findings) {
    findings.fact("method", method_words(&read.scene["method"]));
    if let Some(seed) = read.seed {
        findings.fact("seed", seed.to_string());
    }
    findings.counts(&read.work);
    let last = || read.quantities.iter().filter_map(|it| Some((it, it.values.last()?)));
    let by_two: Vec<(f64, &str)> = last()
        .filter(|(_, it)| it.error_kind == "two_resolutions" && it.value != 0.0)
        .filter_map(|(series, it)| Some((it.error? / it.value.abs(), series.id.as_str())))
        .collect();
    if let Some((worst, id)) = by_two.iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
        findings.fact(
            "resolutions",
            format!(
                "errors of {} come from coarser runs; the largest relative one at the last time is {} ({id})",
                counted(by_two.len(), "quantity").replace("quantitys", "quantities"),
                percent(*worst)
            ),
        );
    }
    let weights: Vec<&ReadWeights> = last().filter_map(|(_, it)| it.weights.as_ref()).collect();
    if let Some(least) = weights.iter().map(|it| it.effective_sample_size).reduce(f64::min) {
        let share = weights.iter().map(|it| it.largest_share).fold(0.0, f64::max);
        findings.fact(
            "effective sample size",
            format!(
                "at least {} at the last time; the largest share of one path is {}",
                short(Some(least)),
                percent(share)
            ),
        );
    }
}

fn sources(scene: &Value) -> Vec<Source> {
    let is = |method: &str| scene["method"].get(method).is_some() || scene["method"] == method;
    let of_method: &[Source] = match () {
        () if is("guided_paths") => &[GIRSANOV_1960, MACKE_2003],
        () if is("subset_simulation") => &[AU_BECK_2001],
        () if is("statistical_linearisation") => &[ROBERTS_1990],
        () if is("conservative_grid") => &[SCHARFETTER_1969],
        () if is("monte_carlo") => &[],
        () => &[CANOR_2013],
    };
    of_method.to_vec()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_probability_that_no_particle_carries_is_a_bound_on_terminal_page_and_chart() {
        let value = |t: f64, value: f64, error: f64, kind: &str| json!({ "t": t, "value": value, "error": error, "error_kind": kind });
        let series = |id: &str, last: Value| {
            let first = value(1.0, 0.5, 0.01, "two_resolutions");
            json!({ "id": id, "quantity": id, "unit": "", "values": [first, last] })
        };
        let result = json!({
            "scene": { "method": "flow_map_fit" }, "work": {}, "unknown": [],
            "quantities": [
                series("exceedance-cell/2", value(2.0, 1.7e-7, 2.5e-7, "bound")),
                series("exceedance-cell/1", value(2.0, 1e-3, 2e-5, "bound")),
                // A covariance may have either sign: its bound is one of the error.
                series("moment/1-1", value(2.0, -0.01, 0.02, "bound")),
            ]
        });
        let found = findings(&result).unwrap();
        let shown: Vec<String> = found.answers.iter().map(Answer::value_and_error).collect();
        assert_eq!(shown, ["< 4.2e-7", "0.001000 ± 2.0e-5", "-0.010 ± 0.020"]);
        let points = &found.charts[0].series[0].points;
        assert_eq!((points[0].bound, points[1].bound), (None, Some(1.7e-7 + 2.5e-7)));
        let cells: Vec<&str> =
            found.tables[0].rows[1].iter().map(|cell| cell.text.as_str()).collect();
        assert_eq!(cells[3..5], ["< 4.2e-7", ""]);
    }
}
