//! What the page shows of a result of the schema `crack-ensemble/1`: outcomes, loads and paths of cracks.

use std::collections::BTreeMap;

use peridyn_sde::statistics::CrackOutcome;
use result_figures::number::{counted, tidy};
use result_pages::{Cell, Chart, Note, Point, Series};
use scene_runs::answers::{Answer, AnswerValue, Number, Statistic, Unknown};
use scene_runs::report::{Report, cell, chart, given_cell, method_words, number_cells, table};

use super::record::{Content, Distributed, Outcome, PathAt, Realisation, Record};
use crate::scene::CrackScene;
use crate::sources::{PARKS_2008, TIM_2019};

/// Strain for a unit of the axis of loads.
const MICRO: f64 = 1e-6;
/// Displacement for a unit of that axis (m).
const MILLI: f64 = 1e-3;

/// What the page shows beside the answers.
pub(super) fn report(scene: &CrackScene, content: &Content<'_>) -> Report {
    let record = content.record;
    let mut report = Report { sources: vec![PARKS_2008, TIM_2019], ..Report::default() };
    notes(record, &mut report);
    charts(record, &mut report);
    tables(record, &mut report);
    report.fact("dynamics", method_words(&scene.dynamics));
    report.fact("realisations", record.realisations.len().to_string());
    report.fact("seed", content.seed.to_string());
    report.counts(&content.work);
    let resolved = serde_json::to_value(content.resolved).unwrap_or_default();
    for (name, unit) in
        [("nodes", ""), ("bonds", ""), ("horizon", " m"), ("dt", " s"), ("duration", " s")]
    {
        if let Some(value) = resolved[name].as_f64() {
            report.fact(name, format!("{}{unit}", tidy(value)));
        }
    }
    if scene.output.vtu.is_empty() {
        report.absent.push(
            "The damage of single realisations is not shown: the key \"output\": { \"vtu\": [0, 1] } of the scene names \
             those to keep."
                .to_owned(),
        );
    }
    report
}

fn notes(record: &Record, report: &mut Report) {
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for failure in &record.failures {
        *reasons.entry(&failure.reason).or_default() += 1;
    }
    let n = record.realisations.len();
    for (reason, failed) in reasons {
        report.notes.push(Note::Warning(format!(
            "{failed} of {} ended in an error and did not count: {reason}",
            counted(n, "realisation")
        )));
    }
    let at_edges = CrackOutcome::GripsBroken.name();
    let n_at_edges = record.realisations.iter().filter(|it| it.outcome == at_edges).count();
    if n_at_edges > 0 {
        report.notes.push(Note::Warning(format!(
            "{n_at_edges} of {} broke at the prescribed displacement: raise `grips.protected` of the scene, or the key `protected` of its supports and load",
            counted(n, "realisation")
        )));
    }
    report.notes.extend(record.unknown.iter().map(Unknown::note));
    for Distributed { words, law, .. } in record.distributions().filter(|it| it.law.missing > 0) {
        let all = law.realisations + law.missing;
        let text = format!(
            "{words}: {} of {} have one and count",
            law.realisations,
            counted(all, "realisation")
        );
        report.notes.push(Note::Remark(text));
    }
}

fn charts(record: &Record, report: &mut Report) {
    let point = |x: f64, number: &Number, spread| Point { spread, ..number.point(x) };
    let mut push =
        |title: &str, labels: [&str; 2], spread: &str, name: &str, points: Vec<Point>| {
            if points.len() > 1 {
                let series = vec![Series { name: name.to_owned(), points }];
                let chart = chart(title.to_owned(), labels.map(str::to_owned), series);
                report.charts.push(Chart { spread: spread.to_owned(), ..chart });
            }
        };
    let deviation = "standard deviation over realisations";
    let loads = record.load.iter();
    let is_displaced = record.load.iter().any(|it| it.displacement.is_some());
    let (title, x_label) = if is_displaced {
        ("Load over displacement", "displacement (mm)")
    } else {
        ("Load over mean strain", "mean strain (1e-6)")
    };
    let loads = loads
        .filter_map(|it| {
            let x =
                it.displacement.map(|u| u / MILLI).or(it.strain.map(|strain| strain / MICRO))?;
            Some(point(x, &it.load, it.standard_deviation))
        })
        .collect();
    push(title, [x_label, "load (N)"], deviation, "mean load", loads);
    let mut by_x: Vec<&PathAt> = record.path.iter().collect();
    by_x.sort_by(|a, b| a.x.total_cmp(&b.x));
    let height = |it: &&PathAt| {
        let law = it.height.as_ref()?;
        Some(point(it.x, &law.mean, law.standard_deviation.as_ref().map(|it| it.value)))
    };
    let heights = by_x.iter().filter_map(height).collect();
    push("Path of the crack", ["x (m)", "height y (m)"], deviation, "mean height", heights);
    let reach = by_x.iter().map(|it| point(it.x, &it.reach, None)).collect();
    push("Cracks that reach an abscissa", ["x (m)", "probability"], "", "probability", reach);
}

fn tables(record: &Record, report: &mut Report) {
    let number = |it: &Number| {
        let [value, error] = number_cells(it);
        vec![value, error, Cell::text(it.error_kind.words())]
    };
    let outcome = |it: &Outcome| [vec![Cell::text(it.outcome)], number(&it.probability)].concat();
    let heads = ["outcome", "probability", "error", "how the error is known"];
    report.tables.push(table("Outcomes", &heads, record.outcomes.iter().map(outcome).collect()));
    let mut rows = Vec::new();
    for Distributed { words, unit, law, .. } in record.distributions() {
        for quantile in &law.quantiles {
            let start =
                [Cell::text(words), Cell::text(unit), given_cell(quantile.probability)].to_vec();
            rows.push([start, number(&quantile.number)].concat());
        }
    }
    let heads = ["quantity", "unit", "probability", "quantile", "error", "how the error is known"];
    report.tables.push(table("Quantiles", &heads, rows));
    let row = |it: &Realisation| {
        vec![
            Cell::number(it.number.to_string(), it.number as f64),
            Cell::text(it.outcome),
            cell(Some(it.length)),
            cell(it.exit),
            cell(it.failure_load),
            Cell::number(it.broken_bonds.to_string(), it.broken_bonds as f64),
        ]
    };
    let heads = [
        "realisation",
        "outcome",
        "crack length (m)",
        "exit (m)",
        "failure load (N)",
        "broken bonds",
    ];
    let all = table("Realisations", &heads, record.realisations.iter().map(row).collect());
    if all.rows.len() <= MOST_REALISATIONS {
        report.tables.push(all);
    }
    if let Some(broken) = &record.broken_bonds {
        let last = AnswerValue::of(*broken);
        let answer = Answer::new(String::new(), String::new(), Statistic::Mean, last);
        let text = answer.shown().value_and_error();
        report.fact("broken bonds in a realisation", text);
    }
}

/// Largest number of realisations that have a row each.
const MOST_REALISATIONS: usize = 1000;
