//! What the page shows of a result of the schema `response-moments/1`: mean and deviation of every response.

use std::collections::BTreeMap;

use result_figures::number::{counted, percent, short};
use result_pages::{Cell, Chart, Note, Point, Series, Source};
use scene_runs::answers::Number;
use scene_runs::report::{self, Report, cell, chart, given_cell, method_words, short_cell};

use super::balance;
use super::record::{Content, GaugeResult, QuantityResult};
use super::response::Response;
use crate::method_scene::MethodScene;
use crate::scene::SmpmScene;
use crate::sources::{CHEN_2019, JOE_KUO_2008, SALTELLI_2010};

/// Largest number of charts of Sobol' indices.
const MOST_INDEX_CHARTS: usize = 6;
/// Curvature ratio above which a first-order variance is off by more than about one per cent.
const CURVED: f64 = 0.03;

/// What the page shows beside the answers.
pub(super) fn report(scene: &SmpmScene, content: &Content) -> Report {
    let [_, time, ..] = scene.units.names();
    let kinds = ["length", "time", "stress", "density", "velocity"];
    let units = kinds.into_iter().zip(scene.units.names()).collect();
    let mut report = Report { units, sources: sources(scene.method), ..Report::default() };
    notes(content, &mut report);
    charts(content, time, &mut report);
    index_charts(content, time, &mut report);
    tables(content, time, &mut report);
    report.notes.extend(balance::rest(scene, &content.balance));
    if let Some((table, chart)) = balance::shown(scene, &content.balance) {
        report.tables.push(table);
        report.charts.push(chart);
    }
    report.fact("method", method_words(&scene.method));
    report.counts(&content.work);
    report.fact("errors", "those of the method on this grid; the error of the grid is in no number: halve the cell and compare");
    for (material, source) in scene.origins() {
        report.fact(&material, source);
    }
    if has_trust(content) {
        let text = format!(
            "below {CURVED} the variance of first order is mostly accurate within one per cent"
        );
        report.fact("curvature ratio", text);
    }
    for field in &content.random_fields {
        let left_out = percent(field.mean_left_out_variance);
        let text = format!(
            "{} terms leave out {left_out} of the variance of the normal field, in the mean",
            field.terms
        );
        report.fact(&format!("random field of {}", field.parameters.join(", ")), text);
    }
    if !scene.fields {
        report.absent.push(
            "Particles over time are not shown: the key \"fields\": true of the scene turns them on.".to_owned(),
        );
    }
    report
}

/// Whether a response has the trust indicators of a Taylor series.
fn has_trust(content: &Content) -> bool {
    let mut quantities = content.gauges.iter().flat_map(|gauge| &gauge.quantities);
    quantities.any(|quantity| quantity.values.iter().any(|value| value.trust.is_some()))
}

fn notes(content: &Content, report: &mut Report) {
    let responses = || {
        content
            .gauges
            .iter()
            .flat_map(|gauge| &gauge.quantities)
            .flat_map(|quantity| &quantity.values)
    };
    if !content.failures.is_empty() {
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        for failure in &content.failures {
            *reasons.entry(&failure.reason).or_default() += 1;
        }
        for (reason, n) in reasons {
            let text =
                format!("{} ended in an error and did not count: {reason}", counted(n, "sample"));
            report.notes.push(Note::Warning(text));
        }
    }
    let trusts = || responses().filter_map(|response| response.trust.as_ref());
    let near = trusts().filter(|trust| trust.switch_within_two_deviations).count();
    if near > 0 {
        report.notes.push(Note::Warning(format!(
            "within two deviations of an elastic-plastic switch, where a Taylor series fails: {}; compare with sampled runs",
            counted(near, "response")
        )));
    }
    let curved: Vec<f64> =
        trusts().filter_map(|it| it.curvature_ratio).filter(|&it| it >= CURVED).collect();
    if let Some(worst) = curved.iter().copied().reduce(f64::max) {
        report.notes.push(Note::Warning(format!(
            "variance of first order off by more than about one per cent, curvature ratio {CURVED} or more: {}, {} at most",
            counted(curved.len(), "response"),
            short(Some(worst))
        )));
    }
    let n_missed = responses().filter(|it| it.is_missed()).count();
    if n_missed > 0 {
        report.notes.push(Note::Warning(format!(
            "the series leaves more than half of a deviation of check runs: {}; the response jumps or bends within a deviation: take a wider step, `sigma_points`, or samples",
            counted(n_missed, "response")
        )));
    }
    report.notes.extend(content.notes.iter().cloned().map(Note::Remark));
}

/// A chart for each quantity, a line for each gauge, at the instants among its times.
fn charts(content: &Content, time: &str, report: &mut Report) {
    let Some(first) = content.gauges.first() else { return };
    for (q, quantity) in first.quantities.iter().enumerate() {
        let point = |it: &Response| {
            let mean = it.mean().point(it.time());
            Point { how: it.how(), spread: it.standard_deviation, ..mean }
        };
        let line = |gauge: &GaugeResult| {
            let values = gauge.quantities.get(q).map_or(&[][..], |it| &it.values);
            let mut points: Vec<Point> =
                values.iter().filter(|it| it.is_instant()).map(point).collect();
            points.sort_by(|a, b| a.x.total_cmp(&b.x));
            Series { name: gauge.name.clone(), points }
        };
        let series: Vec<Series> = content.gauges.iter().map(line).collect();
        if series.iter().all(|it| it.points.len() < 2) {
            continue;
        }
        let name = quantity.name.replace('_', " ");
        let unit =
            if quantity.unit.is_empty() { String::new() } else { format!(" ({})", quantity.unit) };
        let labels = [format!("time ({time})"), format!("{name}{unit}")];
        let chart = chart(format!("Mean {name} over time"), labels, series);
        report.charts.push(Chart { spread: "standard deviation".to_owned(), ..chart });
    }
}

/// Total Sobol' indices of the first responses that have them.
fn index_charts(content: &Content, time: &str, report: &mut Report) {
    let of = |gauge: &GaugeResult, quantity: &QuantityResult| {
        let mut series: BTreeMap<String, Vec<Point>> = BTreeMap::new();
        for response in quantity.values.iter().filter(|it| it.is_instant()) {
            for share in &response.sobol_indices {
                let total = Number::sampled(share.total, share.total_standard_error);
                let points = series.entry(share.parameter.clone()).or_default();
                points.push(total.point(response.time()));
            }
        }
        series.values().any(|points| points.len() > 1).then(|| {
            let name = quantity.name.replace('_', " ");
            let labels = [format!("time ({time})"), "part of the variance".to_owned()];
            let series = series.into_iter().map(|(name, points)| Series { name, points });
            let title = format!("Total Sobol' indices of {name} at {}", gauge.name);
            chart(title, labels, series.collect())
        })
    };
    let gauges = content.gauges.iter();
    let all = gauges.flat_map(|gauge| gauge.quantities.iter().filter_map(move |it| of(gauge, it)));
    report.charts.extend(all.take(MOST_INDEX_CHARTS));
}

/// Heads and rows of the tables.
fn tables(content: &Content, time: &str, report: &mut Report) {
    let (mut all, mut last, mut chances, mut shares) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for gauge in &content.gauges {
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
                    let how = match it.by {
                        "count" => "share of the samples",
                        "differences" => "sum of differences over grids",
                        _ => "normal distribution with these moments",
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
                        short_cell(it.first_standard_error),
                        cell(Some(it.total)),
                        short_cell(it.total_standard_error),
                    ])
                }));
                all.push(row);
            }
        }
    }
    let time = format!("time ({time})");
    let table = |title: &str, more: &[&str], rows: Vec<Vec<Cell>>| {
        report::table(title, &[&["gauge", "quantity", "unit", &time], more].concat(), rows)
    };
    let heads = ["mean", "error", "deviation", "its error", "curvature ratio", "switch distance"];
    report.table_over_time(
        table("All responses", &heads, all),
        table("Responses at the last time", &heads, last),
    );
    if !chances.is_empty() {
        let heads = ["level", "probability", "error", "how"];
        report.tables.push(table("Probabilities of exceedance", &heads, chances));
    }
    if !shares.is_empty() {
        let heads =
            ["parameter", "first-order index", "error", "total index", "error of the total"];
        report.tables.push(table("Sobol' indices", &heads, shares));
    }
}

fn response_row(gauge: &GaugeResult, quantity: &QuantityResult, it: &Response) -> Vec<Cell> {
    let [from, to] = it.window;
    let time = if it.is_instant() { to.to_string() } else { format!("{from} to {to}") };
    let trust = it.trust.as_ref();
    vec![
        Cell::text(gauge.name.clone()),
        Cell::text(quantity.name.replace('_', " ")),
        Cell::text(quantity.unit),
        Cell::number(time, to),
        cell(Some(it.mean)),
        short_cell(it.mean().error),
        cell(it.standard_deviation),
        short_cell(it.deviation().and_then(|it| it.error)),
        short_cell(trust.and_then(|it| it.curvature_ratio)),
        short_cell(trust.and_then(|it| it.switch_distance)),
    ]
}

/// What to cite for a method.
fn sources(method: MethodScene) -> Vec<Source> {
    let of_design = match method {
        MethodScene::QuasiMonteCarlo { .. } => Some(JOE_KUO_2008),
        MethodScene::SobolIndices { .. } => Some(SALTELLI_2010),
        _ => None,
    };
    [CHEN_2019].into_iter().chain(of_design).collect()
}
