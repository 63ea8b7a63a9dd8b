//! Charts and tables of a sweep.

use result_figures::{
    Band, Drawing, Line, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words,
};
use result_pages::{Cell, Note, Point, Series};
use scene_runs::kind::RunError;
use scene_runs::machine::Machine;
use scene_runs::report::{Report, cell, chart, given_cell, method_words, short_cell, table};

use super::record::{Found, SweepContent};
use super::swept_runs::SweptRun;
use crate::scene::SmpmScene;
use crate::sources::{NEYER_1994, RECHT_IPSON_1963};
use crate::sweep_scene::SweepScene;

/// Points of a curve.
const POINTS: usize = 101;

/// What the page shows beside the answers.
pub(super) fn report(scene: &SmpmScene, sweep: &SweepScene, content: &SweepContent) -> Report {
    let kinds = ["length", "time", "stress", "density", "velocity"];
    let units = kinds.into_iter().zip(scene.units.names()).collect();
    let mut report = Report { units, ..Report::default() };
    report.notes.extend(content.notes.iter().cloned().map(Note::Remark));
    let result = &content.sweep;
    let number = label(&sweep.number, result.unit);
    if !result.probabilities.is_empty() {
        report.sources.push(NEYER_1994);
        let point = |it: &super::record::ProbabilityAt| Point {
            x: it.value,
            y: it.probability,
            error: Some(it.error()),
            bound: None,
            how: "larger side of the 95 % interval".to_owned(),
            spread: None,
        };
        let mut points: Vec<Point> = result.probabilities.iter().map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let title = format!("Probability of {}", sweep.event.name);
        let labels = [number.clone(), "probability".to_owned()];
        report.charts.push(chart(
            title,
            labels,
            vec![Series { name: "probit model".to_owned(), points }],
        ));
        let row = |it: &super::record::ProbabilityAt| {
            let [low, high] = it.interval;
            vec![
                cell(Some(it.value)),
                cell(Some(it.probability)),
                cell(Some(low)),
                cell(Some(high)),
            ]
        };
        let heads = [number.as_str(), "probability", "2.5 %", "97.5 %"];
        let rows = result.probabilities.iter().map(row).collect();
        report.tables.push(table("Probability", &heads, rows));
    }
    if let Some(fit) = &result.residual_velocity {
        report.sources.push(RECHT_IPSON_1963);
        let text = format!(
            "v_r = {} (v^{} - {}^{})^(1/{}), root mean square of the rest {}; its constants have no error estimate",
            short(fit.factor),
            short(fit.exponent),
            short(fit.limit),
            short(fit.exponent),
            short(fit.exponent),
            short(fit.deviation),
        );
        report.fact("residual velocity v_r over impact velocity v", text);
    }
    let decisive = label(&sweep.event.quantity, unit_of_event(scene, sweep));
    let row = |it: &SweptRun| {
        let outcome = match (&it.failure, it.is_event(sweep)) {
            (Some(reason), _) => format!("failed: {reason}"),
            (None, true) => sweep.event.name.clone(),
            (None, false) => format!("not {}", sweep.event.name),
        };
        let sample = it.sample.map_or_else(|| "centre".to_owned(), |sample| sample.to_string());
        let last = it.outcome.map(|[_, last]| last);
        vec![given_cell(it.value), Cell::text(sample), short_cell(last), Cell::text(outcome)]
    };
    let heads = [number.as_str(), "sample", &decisive, "outcome"];
    report.tables.push(table("Runs", &heads, result.runs.iter().map(row).collect()));
    let [without, with] = result.bracket_at_centre;
    let text = format!("between {} and {}", short(without), short(with));
    report.fact("limit at the centre of the parameters", text);
    report.fact("method", method_words(&scene.method));
    scene.origins().iter().for_each(|(material, source)| report.fact(material, source.clone()));
    report.counts(&content.work);
    report.fact("errors", "those of the estimate on this grid; the error of the grid is in no number: halve the cell and compare");
    report
}

fn short(value: f64) -> String {
    result_figures::number::short(Some(value))
}

fn label(name: &str, unit: &str) -> String {
    let name = name.replace('_', " ");
    if unit.is_empty() { name } else { format!("{name} ({unit})") }
}

fn unit_of_event(scene: &SmpmScene, sweep: &SweepScene) -> &'static str {
    sweep.event.quantity.parse().map_or("", |quantity| scene.units.of(quantity))
}

/// The probability with its band, and the deciding quantity of all runs with the fit of residual velocities.
pub(super) fn drawings(
    scene: &SmpmScene,
    sweep: &SweepScene,
    content: &SweepContent,
    found: &Found,
) -> Result<Vec<Drawing>, RunError> {
    let result = &content.sweep;
    let (low, high) = (sweep.from.min(sweep.to), sweep.from.max(sweep.to));
    let values = || (0..POINTS).map(move |k| low + (high - low) * k as f64 / (POINTS - 1) as f64);
    let words = |subtitle: String, y_label: String| Words {
        title: scene.title.clone(),
        subtitle,
        x_label: label(&sweep.number, result.unit),
        y_label,
        caption: vec![Machine::read().caption()],
    };
    let series = |words, lines, bands, references| TimeSeries {
        words,
        scale: Scale::Linear,
        lines,
        bands,
        references,
    };
    let mut drawings = Vec::new();
    if let Found::Probability(model) = found {
        let of = |value: f64| (value, model.probability(sweep.level(value)));
        let points = values().map(of).map(|(x, band)| (x, Some(band.value))).collect();
        let line = Line { name: "probit model".to_owned(), points };
        let points = values().map(of).map(|(x, band)| (x, band.interval[0], band.interval[1]));
        let band = Band { points: points.collect() };
        let words = words(
            format!("Shaded: interval of 95 %, {} runs", result.runs.len()),
            format!("probability of {}", sweep.event.name),
        );
        let chart = series(words, vec![line], vec![band], Vec::new());
        drawings.push(Drawing::time_series("probability", &chart).map_err(RunError::solver)?);
    }
    let point = |it: &SweptRun| Some((it.value, it.outcome?[1]));
    let points: Vec<(f64, f64)> = result.runs.iter().filter_map(point).collect();
    let mut lines = Vec::new();
    if let Some(fit) = &result.residual_velocity {
        let signs = points.iter().filter(|&&(_, last)| sweep.event.occurs(last));
        let sign = signs.map(|&(_, last)| last.signum()).next().unwrap_or(1.0);
        let points = values().map(|v| (v, Some(sign * fit.at(v.abs())))).collect();
        lines.push(Line { name: "fit by Recht and Ipson".to_owned(), points });
    }
    let points = points.into_iter().map(|(x, y)| ReferencePoint { x, y, error: None }).collect();
    let runs = ReferencePoints { name: "runs".to_owned(), points };
    let quantity = label(&sweep.event.quantity, unit_of_event(scene, sweep));
    let words = words(format!("{} at the last time", sweep.event.gauge), quantity);
    let chart = series(words, lines, Vec::new(), vec![runs]);
    drawings.push(Drawing::time_series(&sweep.event.quantity, &chart).map_err(RunError::solver)?);
    Ok(drawings)
}
