//! What a run of the schema `crack-ensemble/1` found: outcomes, loads and paths of cracks.

use std::collections::BTreeMap;

use peridyn_sde::statistics::CrackOutcome;
use result_figures::number::{counted, tidy};
use result_pages::{Answer, Cell, Chart, Note, Point, Series, Table};
use serde::Deserialize;
use serde_json::Value;

use crate::findings::sources::{PARKS_2008, TIM_2019};
use crate::findings::{
    Findings, ReadNumber, ReadQuantile, ReadUnknown, cell, given_cell, how, method_words,
    short_cell,
};

#[derive(Debug, Deserialize)]
struct Read {
    scene: Value,
    seed: u64,
    resolved: Value,
    work: Value,
    unknown: Vec<ReadUnknown>,
    failures: Vec<ReadFailure>,
    outcomes: Vec<ReadOutcome>,
    path: Vec<ReadPath>,
    exit: Option<ReadLaw>,
    length: Option<ReadLaw>,
    failure_load: Option<ReadLaw>,
    broken_bonds: Option<ReadNumber>,
    realisations: Vec<ReadRealisation>,
    load: Vec<ReadLoad>,
}

#[derive(Debug, Deserialize)]
struct ReadFailure {
    reason: String,
}

#[derive(Debug, Deserialize)]
struct ReadOutcome {
    outcome: String,
    probability: ReadNumber,
}

#[derive(Debug, Deserialize)]
struct ReadPath {
    x: f64,
    reach: ReadNumber,
    height: Option<ReadLaw>,
}

#[derive(Debug, Deserialize)]
struct ReadLaw {
    realisations: usize,
    missing: usize,
    mean: ReadNumber,
    standard_deviation: Option<ReadInterval>,
    quantiles: Vec<ReadQuantile>,
}

#[derive(Debug, Deserialize)]
struct ReadInterval {
    value: f64,
    low: f64,
    high: f64,
}

#[derive(Debug, Deserialize)]
struct ReadRealisation {
    number: u64,
    outcome: String,
    length: f64,
    exit: Option<f64>,
    failure_load: Option<f64>,
    broken_bonds: u64,
}

#[derive(Debug, Deserialize)]
struct ReadLoad {
    strain: Option<f64>,
    displacement: Option<f64>,
    load: ReadNumber,
    standard_deviation: f64,
}

/// Strain for a unit of the axis of loads.
const MICRO: f64 = 1e-6;
/// Displacement for a unit of that axis (m).
const MILLI: f64 = 1e-3;

impl Read {
    /// Distributions with their names and units.
    fn laws(&self) -> impl Iterator<Item = (&'static str, &'static str, &ReadLaw)> {
        [
            ("failure load", "N", &self.failure_load),
            ("height of exit", "m", &self.exit),
            ("crack length", "m", &self.length),
        ]
        .into_iter()
        .filter_map(|(name, unit, law)| Some((name, unit, law.as_ref()?)))
    }
}

/// Reads the findings from a result.
pub(super) fn findings(result: &Value) -> Result<Findings, serde_json::Error> {
    let read = Read::deserialize(result)?;
    let mut findings = Findings::default();
    answers(&read, &mut findings);
    notes(&read, &mut findings);
    charts(&read, &mut findings);
    tables(&read, &mut findings);
    findings.fact("dynamics", method_words(&read.scene["dynamics"]));
    findings.fact("realisations", read.realisations.len().to_string());
    findings.fact("seed", read.seed.to_string());
    findings.counts(&read.work);
    for (name, unit) in
        [("nodes", ""), ("bonds", ""), ("horizon", " m"), ("dt", " s"), ("duration", " s")]
    {
        if let Some(value) = read.resolved[name].as_f64() {
            findings.fact(name, format!("{}{unit}", tidy(value)));
        }
    }
    let is_empty = |list: &Value| list.as_array().is_none_or(Vec::is_empty);
    if is_empty(&read.scene["output"]["vtu"]) {
        findings.absent.push(
            "The damage of single realisations is not shown: the key \"output\": { \"vtu\": [0, 1] } of the scene names \
             those to keep."
                .to_owned(),
        );
    }
    findings.sources = vec![PARKS_2008, TIM_2019];
    Ok(findings)
}

fn answer(quantity: String, unit: &str, number: &ReadNumber) -> Answer {
    Answer {
        quantity,
        at: String::new(),
        value: number.value,
        error: number.error,
        bound: None,
        unit: unit.to_owned(),
        how: how(&number.error_kind),
    }
}

fn answers(read: &Read, findings: &mut Findings) {
    for (name, unit, law) in read.laws() {
        findings.answers.push(answer(format!("{name}, mean"), unit, &law.mean));
        if let Some(deviation) = law.standard_deviation.as_ref().filter(|_| name == "failure load")
        {
            let half = 0.5 * (deviation.high - deviation.low);
            findings.answers.push(Answer {
                quantity: format!("{name}, standard deviation"),
                at: String::new(),
                value: deviation.value,
                error: Some(half),
                bound: None,
                unit: unit.to_owned(),
                how: "half of the 95 % bootstrap interval".to_owned(),
            });
        }
    }
    let likely = read.outcomes.iter().filter(|it| it.probability.value > 0.0);
    findings
        .answers
        .extend(likely.map(|it| answer(format!("P({})", it.outcome), "", &it.probability)));
    let of_laws: usize = read.laws().map(|(_, _, law)| 2 + law.quantiles.len()).sum();
    let heights = read.path.iter().filter_map(|it| it.height.as_ref());
    let of_path: usize = heights.map(|law| 3 + law.quantiles.len()).sum();
    let n_values = of_laws + of_path + read.outcomes.len() + read.load.len();
    findings.n_more = n_values.saturating_sub(findings.answers.len());
}

fn notes(read: &Read, findings: &mut Findings) {
    findings.notes.extend(read.unknown.iter().map(ReadUnknown::note));
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for failure in &read.failures {
        *reasons.entry(&failure.reason).or_default() += 1;
    }
    let n = read.realisations.len();
    for (reason, failed) in reasons {
        findings.notes.push(Note::Warning(format!(
            "{failed} of {} ended in an error and did not count: {reason}",
            counted(n, "realisation")
        )));
    }
    let at_edges = CrackOutcome::GripsBroken.name();
    let n_at_edges = read.realisations.iter().filter(|it| it.outcome == at_edges).count();
    if n_at_edges > 0 {
        findings.notes.push(Note::Warning(format!(
            "{n_at_edges} of {} broke at the prescribed displacement: raise `grips.protected` of the scene, or the key `protected` of its supports and load",
            counted(n, "realisation")
        )));
    }
    for (name, _, law) in read.laws().filter(|(_, _, law)| law.missing > 0) {
        let all = law.realisations + law.missing;
        let text = format!(
            "{name}: {} of {} have one and count",
            law.realisations,
            counted(all, "realisation")
        );
        findings.notes.push(Note::Remark(text));
    }
    findings.note_order_of_magnitude();
    findings.note_unknown_errors();
}

fn charts(read: &Read, findings: &mut Findings) {
    let point = |x: f64, number: &ReadNumber, spread| Point {
        x,
        y: number.value,
        error: number.error,
        bound: None,
        how: how(&number.error_kind),
        spread,
    };
    let mut push =
        |title: &str, labels: [&str; 2], spread: &str, name: &str, points: Vec<Point>| {
            if points.len() > 1 {
                let [x_label, y_label] = labels.map(str::to_owned);
                let series = vec![Series { name: name.to_owned(), points }];
                let (title, spread) = (title.to_owned(), spread.to_owned());
                findings.charts.push(Chart {
                    title,
                    x_label,
                    y_label,
                    is_logarithmic: false,
                    x_is_logarithmic: false,
                    spread,
                    series,
                });
            }
        };
    let deviation = "standard deviation over realisations";
    let loads = read.load.iter();
    let is_displaced = read.load.iter().any(|it| it.displacement.is_some());
    let (title, x_label) = if is_displaced {
        ("Load over displacement", "displacement (mm)")
    } else {
        ("Load over mean strain", "mean strain (1e-6)")
    };
    let loads = loads
        .filter_map(|it| {
            let x =
                it.displacement.map(|u| u / MILLI).or(it.strain.map(|strain| strain / MICRO))?;
            Some(point(x, &it.load, Some(it.standard_deviation)))
        })
        .collect();
    push(title, [x_label, "load (N)"], deviation, "mean load", loads);
    let mut by_x: Vec<&ReadPath> = read.path.iter().collect();
    by_x.sort_by(|a, b| a.x.total_cmp(&b.x));
    let height = |it: &&ReadPath| {
        let law = it.height.as_ref()?;
        Some(point(it.x, &law.mean, law.standard_deviation.as_ref().map(|it| it.value)))
    };
    let heights = by_x.iter().filter_map(height).collect();
    push("Path of the crack", ["x (m)", "height y (m)"], deviation, "mean height", heights);
    let reach = by_x.iter().map(|it| point(it.x, &it.reach, None)).collect();
    push("Cracks that reach an abscissa", ["x (m)", "probability"], "", "probability", reach);
}

fn tables(read: &Read, findings: &mut Findings) {
    let table = |title: &str, heads: &[&str], rows: Vec<Vec<Cell>>| Table {
        title: title.to_owned(),
        about: String::new(),
        heads: heads.iter().map(|&head| head.to_owned()).collect(),
        rows,
    };
    let number = |it: &ReadNumber| {
        vec![cell(Some(it.value)), short_cell(it.error), Cell::text(how(&it.error_kind))]
    };
    let outcome =
        |it: &ReadOutcome| [vec![Cell::text(it.outcome.clone())], number(&it.probability)].concat();
    let heads = ["outcome", "probability", "error", "how the error is known"];
    findings.tables.push(table("Outcomes", &heads, read.outcomes.iter().map(outcome).collect()));
    let mut rows = Vec::new();
    for (name, unit, law) in read.laws() {
        for quantile in &law.quantiles {
            let start =
                [Cell::text(name), Cell::text(unit), given_cell(quantile.probability)].to_vec();
            rows.push([start, number(&quantile.number)].concat());
        }
    }
    let heads = ["quantity", "unit", "probability", "quantile", "error", "how the error is known"];
    findings.tables.push(table("Quantiles", &heads, rows));
    let row = |it: &ReadRealisation| {
        vec![
            Cell::number(it.number.to_string(), it.number as f64),
            Cell::text(it.outcome.clone()),
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
    let all = table("Realisations", &heads, read.realisations.iter().map(row).collect());
    if all.rows.len() <= MOST_REALISATIONS {
        findings.tables.push(all);
    }
    if let Some(broken) = &read.broken_bonds {
        let text = answer(String::new(), "", broken).value_and_error();
        findings.fact("broken bonds in a realisation", text);
    }
}

/// Largest number of realisations that have a row each.
const MOST_REALISATIONS: usize = 1000;
