//! What a run of the schema `response-moments/1` found: mean and deviation of every response.

use std::collections::BTreeMap;

use result_figures::number::{counted, percent, short};
use result_pages::{Answer, Cell, Chart, Note, Point, Series, Source, Table};
use serde::Deserialize;
use serde_json::Value;

use crate::findings::sources::{CHEN_2019, JOE_KUO_2008, SALTELLI_2010};
use crate::findings::{Findings, cell, given_cell, method_words, short_cell};
use crate::smpm::scene::UnitsScene;

#[derive(Debug, Deserialize)]
struct Read {
    scene: Value,
    work: Value,
    #[serde(default)]
    notes: Vec<String>,
    failures: Vec<ReadFailure>,
    #[serde(default)]
    random_fields: Vec<ReadField>,
    gauges: Vec<ReadGauge>,
}

#[derive(Debug, Deserialize)]
struct ReadFailure {
    reason: String,
}

#[derive(Debug, Deserialize)]
struct ReadField {
    parameters: Vec<String>,
    terms: usize,
    mean_left_out_variance: f64,
}

#[derive(Debug, Deserialize)]
struct ReadGauge {
    name: String,
    quantities: Vec<ReadQuantity>,
}

#[derive(Debug, Deserialize)]
struct ReadQuantity {
    name: String,
    unit: String,
    values: Vec<ReadResponse>,
}

#[derive(Debug, Deserialize)]
struct ReadResponse {
    window: [f64; 2],
    mean: f64,
    mean_standard_error: Option<f64>,
    variance_standard_error: Option<f64>,
    standard_deviation: Option<f64>,
    trust: Option<ReadTrust>,
    #[serde(default)]
    sobol_indices: Vec<ReadShares>,
    #[serde(default)]
    exceedance: Vec<ReadChance>,
}

#[derive(Debug, Deserialize)]
struct ReadTrust {
    curvature_ratio: Option<f64>,
    switch_distance: Option<f64>,
    switch_within_two_deviations: bool,
}

#[derive(Debug, Deserialize)]
struct ReadShares {
    parameter: String,
    first: f64,
    first_standard_error: f64,
    total: f64,
    total_standard_error: f64,
}

#[derive(Debug, Deserialize)]
struct ReadChance {
    level: f64,
    probability: f64,
    standard_error: Option<f64>,
    by: String,
}

/// Answers that are shown first.
const FIRST: usize = 6;
/// Largest number of charts of Sobol' indices.
const MOST_INDEX_CHARTS: usize = 6;
/// Curvature ratio above which a first-order variance is off by more than about one per cent.
const CURVED: f64 = 0.03;

impl ReadResponse {
    const fn is_instant(&self) -> bool {
        self.window[0] >= self.window[1]
    }

    /// Error of the standard deviation, from that of the variance to first order.
    fn deviation_error(&self) -> Option<f64> {
        let deviation = self.standard_deviation.filter(|&deviation| deviation > 0.0)?;
        Some(self.variance_standard_error? / (2.0 * deviation))
    }

    fn how(&self) -> String {
        match (&self.trust, self.mean_standard_error, self.standard_deviation) {
            (_, Some(_), _) => "standard error of the samples".to_owned(),
            (Some(ReadTrust { curvature_ratio: Some(ratio), .. }), ..) => {
                format!("Taylor series, no error estimate; curvature ratio {}", short(Some(*ratio)))
            }
            (Some(_), ..) => "Taylor series, no error estimate".to_owned(),
            (None, None, Some(_)) => "no error estimate".to_owned(),
            (None, None, None) => "one run, no error estimate".to_owned(),
        }
    }
}

/// Reads the findings from a result.
pub(super) fn findings(result: &Value) -> Result<Findings, serde_json::Error> {
    let read = Read::deserialize(result)?;
    let units = UnitsScene::deserialize(&read.scene["units"])?;
    let [_, time, ..] = units.names();
    let mut findings = Findings::default();
    let all =
        || read.gauges.iter().flat_map(|gauge| gauge.quantities.iter().map(move |it| (gauge, it)));
    for (gauge, quantity) in all() {
        findings.answers.extend(answers(gauge, quantity, time));
    }
    findings.answers.truncate(FIRST);
    let n_values: usize = all().map(|(_, quantity)| quantity.values.len()).sum();
    let of_one = if all().any(|(_, it)| it.values.iter().any(|v| v.standard_deviation.is_some())) {
        2
    } else {
        1
    };
    findings.n_more = (of_one * n_values).saturating_sub(findings.answers.len());
    notes(&read, &mut findings);
    charts(&read, time, &mut findings);
    index_charts(&read, time, &mut findings);
    tables(&read, time, &mut findings);
    findings.fact("method", method_words(&read.scene["method"]));
    findings.counts(&read.work);
    if !findings.answers.is_empty() && has_trust(&read) {
        let text = format!(
            "below {CURVED} the variance of first order is mostly accurate within one per cent"
        );
        findings.fact("curvature ratio", text);
    }
    for field in &read.random_fields {
        let left_out = percent(field.mean_left_out_variance);
        let text = format!(
            "{} terms leave out {left_out} of the variance of the normal field, in the mean",
            field.terms
        );
        findings.fact(&format!("random field of {}", field.parameters.join(", ")), text);
    }
    if read.scene["fields"] != true {
        findings.absent.push(
            "Particles over time are not shown: the key \"fields\": true of the scene turns them on.".to_owned(),
        );
    }
    findings.sources = sources(&read.scene);
    Ok(findings)
}

/// Whether a response has the trust indicators of a Taylor series.
fn has_trust(read: &Read) -> bool {
    let mut quantities = read.gauges.iter().flat_map(|gauge| &gauge.quantities);
    quantities.any(|quantity| quantity.values.iter().any(|value| value.trust.is_some()))
}

/// Mean and standard deviation at the last time.
fn answers(gauge: &ReadGauge, quantity: &ReadQuantity, time: &str) -> Vec<Answer> {
    let Some(last) = quantity.values.last() else { return Vec::new() };
    let [from, to] = last.window;
    let at = if last.is_instant() {
        format!("t = {to} {time}")
    } else {
        format!("t = {from} to {to} {time}")
    };
    let words = format!("{} at {}", quantity.name.replace('_', " "), gauge.name);
    let answer = |part: &str, value, error| Answer {
        quantity: format!("{words}, {part}"),
        at: at.clone(),
        value,
        error,
        bound: None,
        unit: quantity.unit.clone(),
        how: last.how(),
    };
    let is_sampled = last.mean_standard_error.is_some() || last.standard_deviation.is_some();
    let mean =
        answer(if is_sampled { "mean" } else { "value" }, last.mean, last.mean_standard_error);
    let deviation = last.standard_deviation;
    let deviation = deviation.map(|it| answer("standard deviation", it, last.deviation_error()));
    [mean].into_iter().chain(deviation).collect()
}

fn notes(read: &Read, findings: &mut Findings) {
    let responses = || {
        read.gauges.iter().flat_map(|gauge| &gauge.quantities).flat_map(|quantity| &quantity.values)
    };
    if !read.failures.is_empty() {
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        for failure in &read.failures {
            *reasons.entry(&failure.reason).or_default() += 1;
        }
        for (reason, n) in reasons {
            let text =
                format!("{} ended in an error and did not count: {reason}", counted(n, "sample"));
            findings.notes.push(Note::Warning(text));
        }
    }
    let trusts = || responses().filter_map(|response| response.trust.as_ref());
    let near = trusts().filter(|trust| trust.switch_within_two_deviations).count();
    if near > 0 {
        findings.notes.push(Note::Warning(format!(
            "within two deviations of an elastic-plastic switch, where a Taylor series fails: {}; compare with sampled runs",
            counted(near, "response")
        )));
    }
    let curved: Vec<f64> =
        trusts().filter_map(|it| it.curvature_ratio).filter(|&it| it >= CURVED).collect();
    if let Some(worst) = curved.iter().copied().reduce(f64::max) {
        findings.notes.push(Note::Warning(format!(
            "variance of first order off by more than about one per cent, curvature ratio {CURVED} or more: {}, {} at most",
            counted(curved.len(), "response"),
            short(Some(worst))
        )));
    }
    findings.notes.extend(read.notes.iter().cloned().map(Note::Remark));
    findings.note_order_of_magnitude();
    findings.note_unknown_errors();
}

/// A chart for each quantity, a line for each gauge, at the instants among its times.
fn charts(read: &Read, time: &str, findings: &mut Findings) {
    let Some(first) = read.gauges.first() else { return };
    for (q, quantity) in first.quantities.iter().enumerate() {
        let point = |it: &ReadResponse| Point {
            x: it.window[1],
            y: it.mean,
            error: it.mean_standard_error,
            bound: None,
            how: it.how(),
            spread: it.standard_deviation,
        };
        let line = |gauge: &ReadGauge| {
            let values = gauge.quantities.get(q).map_or(&[][..], |it| &it.values);
            let mut points: Vec<Point> =
                values.iter().filter(|it| it.is_instant()).map(point).collect();
            points.sort_by(|a, b| a.x.total_cmp(&b.x));
            Series { name: gauge.name.clone(), points }
        };
        let series: Vec<Series> = read.gauges.iter().map(line).collect();
        if series.iter().all(|it| it.points.len() < 2) {
            continue;
        }
        let name = quantity.name.replace('_', " ");
        let unit =
            if quantity.unit.is_empty() { String::new() } else { format!(" ({})", quantity.unit) };
        findings.charts.push(Chart {
            title: format!("Mean {name} over time"),
            x_label: format!("time ({time})"),
            y_label: format!("{name}{unit}"),
            is_logarithmic: false,

            x_is_logarithmic: false,
            spread: "standard deviation".to_owned(),
            series,
        });
    }
}

/// Total Sobol' indices of the first responses that have them.
fn index_charts(read: &Read, time: &str, findings: &mut Findings) {
    let of = |gauge: &ReadGauge, quantity: &ReadQuantity| {
        let mut series: BTreeMap<String, Vec<Point>> = BTreeMap::new();
        for response in quantity.values.iter().filter(|it| it.is_instant()) {
            for share in &response.sobol_indices {
                series.entry(share.parameter.clone()).or_default().push(Point {
                    x: response.window[1],
                    y: share.total,
                    error: Some(share.total_standard_error),
                    bound: None,
                    how: "standard error of the samples".to_owned(),
                    spread: None,
                });
            }
        }
        series.values().any(|points| points.len() > 1).then(|| Chart {
            title: format!(
                "Total Sobol' indices of {} at {}",
                quantity.name.replace('_', " "),
                gauge.name
            ),
            x_label: format!("time ({time})"),
            y_label: "part of the variance".to_owned(),
            is_logarithmic: false,

            x_is_logarithmic: false,
            spread: String::new(),
            series: series.into_iter().map(|(name, points)| Series { name, points }).collect(),
        })
    };
    let all = read
        .gauges
        .iter()
        .flat_map(|gauge| gauge.quantities.iter().filter_map(move |it| of(gauge, it)));
    findings.charts.extend(all.take(MOST_INDEX_CHARTS));
}

/// Heads and rows of the tables.
fn tables(read: &Read, time: &str, findings: &mut Findings) {
    let (mut all, mut last, mut chances, mut shares) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for gauge in &read.gauges {
        for quantity in &gauge.quantities {
            let n = quantity.values.len();
            for (k, response) in quantity.values.iter().enumerate() {
                let row = response_row(gauge, quantity, response);
                if k + 1 == n {
                    last.push(row.clone());
                }
                let head = &row[..4];
                let with = |cells: Vec<Cell>| [head, &cells].concat();
                chances.extend(response.exceedance.iter().map(|it| {
                    let how = if it.by == "count" {
                        "share of the samples"
                    } else {
                        "normal distribution with these moments"
                    };
                    with(vec![
                        given_cell(it.level),
                        cell(Some(it.probability)),
                        short_cell(it.standard_error),
                        Cell::text(how),
                    ])
                }));
                shares.extend(response.sobol_indices.iter().map(|it| {
                    with(vec![
                        Cell::text(it.parameter.clone()),
                        cell(Some(it.first)),
                        short_cell(Some(it.first_standard_error)),
                        cell(Some(it.total)),
                        short_cell(Some(it.total_standard_error)),
                    ])
                }));
                all.push(row);
            }
        }
    }
    let start = ["gauge", "quantity", "unit"].map(str::to_owned);
    let table = |title: &str, more: &[&str], rows: Vec<Vec<Cell>>| {
        let time = [format!("time ({time})")];
        let more = more.iter().map(|&head| head.to_owned());
        let heads = start.iter().chain(&time).cloned().chain(more).collect();
        Table { title: title.to_owned(), about: String::new(), heads, rows }
    };
    let heads = ["mean", "error", "deviation", "its error", "curvature ratio", "switch distance"];
    findings.table_over_time(
        table("All responses", &heads, all),
        table("Responses at the last time", &heads, last),
    );
    if !chances.is_empty() {
        let heads = ["level", "probability", "error", "how"];
        findings.tables.push(table("Probabilities of exceedance", &heads, chances));
    }
    if !shares.is_empty() {
        let heads =
            ["parameter", "first-order index", "error", "total index", "error of the total"];
        findings.tables.push(table("Sobol' indices", &heads, shares));
    }
}

fn response_row(gauge: &ReadGauge, quantity: &ReadQuantity, it: &ReadResponse) -> Vec<Cell> {
    let [from, to] = it.window;
    let time = if it.is_instant() { to.to_string() } else { format!("{from} to {to}") };
    let trust = it.trust.as_ref();
    vec![
        Cell::text(gauge.name.clone()),
        Cell::text(quantity.name.replace('_', " ")),
        Cell::text(quantity.unit.clone()),
        Cell::number(time, to),
        cell(Some(it.mean)),
        short_cell(it.mean_standard_error),
        cell(it.standard_deviation),
        short_cell(it.deviation_error()),
        short_cell(trust.and_then(|it| it.curvature_ratio)),
        short_cell(trust.and_then(|it| it.switch_distance)),
    ]
}

fn sources(scene: &Value) -> Vec<Source> {
    let is = |method: &str| scene["method"].get(method).is_some();
    let of_design = [("quasi_monte_carlo", JOE_KUO_2008), ("sobol_indices", SALTELLI_2010)];
    let more = of_design.into_iter().filter(|(method, _)| is(method)).map(|(_, source)| source);
    [CHEN_2019].into_iter().chain(more).collect()
}
