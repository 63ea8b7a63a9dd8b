//! Error against cost on logarithmic axes.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Drawn, FRAME, INK, Look, SOFT, STRIP, Type, draw_svg};
use super::legend::{
    FRAME_TOP, FRAME_X, SHEET, Sample, draw_frame, draw_grid, draw_legend, draw_words, frame_bottom,
};
use super::placement::{Block, Occupied};
use crate::data::{Method, Run, RunOutcome, Scale, WorkPrecision};
use crate::error::{ChartError, check_finite, check_positive};

const MARKER: f64 = 4.8;
/// Height of the strip for runs that failed.
const STRIP_HEIGHT: f64 = 26.0;

/// Draws a work-precision chart as SVG.
///
/// # Errors
/// [`ChartError`] for a cost or an error that is not positive and finite, or a chart without a point.
pub fn work_precision(chart: &WorkPrecision) -> Result<String, ChartError> {
    check(chart)?;
    let bottom = frame_bottom(&chart.words);
    let has_failures = failures(chart).next().is_some();
    let top = if has_failures { FRAME_TOP + STRIP_HEIGHT } else { FRAME_TOP };
    let costs = chart
        .series
        .iter()
        .flat_map(|method| &method.runs)
        .flat_map(|run| ends(run.cost, run.cost_error));
    let errors = chart.series.iter().flat_map(|method| &method.runs).filter_map(error_of);
    let x = Axis::spanning(Scale::Log, costs, FRAME_X);
    let y =
        Axis::spanning(Scale::Log, errors.flat_map(|(value, bar)| ends(value, bar)), (bottom, top));
    draw_svg(SHEET, &chart.words.title, |canvas| {
        draw_words(canvas, &chart.words, bottom)?;
        draw_grid(canvas, &x, &y)?;
        draw_series(canvas, chart, &x, &y)?;
        if has_failures {
            draw_failures(canvas, chart, &x, top)?;
        }
        draw_frame(canvas, &x, &y, FRAME_TOP)?;
        let entries = chart.series.iter().enumerate();
        let entries = entries
            .map(|(i, method)| (Sample::LineAndMarker(Look::of_series(i)), method.name.as_str()));
        let failed =
            has_failures.then_some((Sample::Cross, "no result; the JSON gives the reason"));
        draw_legend(canvas, entries.chain(failed))
    })
}

fn check(chart: &WorkPrecision) -> Result<(), ChartError> {
    let mut n_points = 0;
    for method in &chart.series {
        for run in &method.runs {
            n_points += 1;
            check_positive(&method.name, "cost", run.cost)?;
            check_finite(&method.name, "scatter of the cost", run.cost_error.unwrap_or(0.0))?;
            if let Some((value, bar)) = error_of(run) {
                check_positive(&method.name, "error", value)?;
                check_finite(&method.name, "standard error", bar.unwrap_or(0.0))?;
            }
        }
    }
    if n_points == 0 { Err(ChartError::Empty { title: chart.words.title.clone() }) } else { Ok(()) }
}

const fn error_of(run: &Run) -> Option<(f64, Option<f64>)> {
    match run.outcome {
        RunOutcome::Error { value, standard_error } => Some((value, standard_error)),
        RunOutcome::Failed { .. } => None,
    }
}

fn failures(chart: &WorkPrecision) -> impl Iterator<Item = (usize, &Run)> {
    let runs = chart
        .series
        .iter()
        .enumerate()
        .flat_map(|(i, method)| method.runs.iter().map(move |run| (i, run)));
    runs.filter(|(_, run)| matches!(run.outcome, RunOutcome::Failed { .. }))
}

/// Range required by a value and its error bar, without a lower end that would span decades by itself.
fn ends(value: f64, bar: Option<f64>) -> [f64; 3] {
    let bar = bar.unwrap_or(0.0);
    [value, value + bar, (value - bar).max(0.3 * value)]
}

fn points(method: &Method, x: &Axis, y: &Axis) -> Vec<(f64, f64)> {
    let place = |run: &Run| error_of(run).map(|(value, _)| (x.place(run.cost), y.place(value)));
    method.runs.iter().filter_map(place).collect()
}

/// Draws lines, then error bars, markers and labels: the most important elements are on top.
fn draw_series(canvas: &Canvas<'_>, chart: &WorkPrecision, x: &Axis, y: &Axis) -> Drawn {
    let mut occupied = Occupied::new(Block::new(x.start(), y.end(), x.end(), y.start()));
    for (i, method) in chart.series.iter().enumerate() {
        let points = points(method, x, y);
        canvas.dashed_line(&points, Look::of_series(i), 1.7)?;
        occupied.add_line(&points);
        for point in points {
            occupied.add(Block::around(point, MARKER + 2.0));
        }
    }
    for (i, method) in chart.series.iter().enumerate() {
        for run in &method.runs {
            draw_bars(canvas, run, Look::of_series(i), (x, y), &mut occupied)?;
        }
    }
    for (i, method) in chart.series.iter().enumerate() {
        for &point in &points(method, x, y) {
            canvas.marker(point, Look::of_series(i), MARKER)?;
        }
    }
    for run in chart.series.iter().flat_map(|method| &method.runs) {
        if let (Some(label), Some((value, _))) = (&run.label, error_of(run)) {
            let spot = occupied.place_text(label, 10.5, (x.place(run.cost), y.place(value)));
            canvas.text(label, spot, Anchor::Middle, Type::new(10.5, INK))?;
        }
    }
    Ok(())
}

fn draw_bars(
    canvas: &Canvas<'_>,
    run: &Run,
    look: Look,
    (x, y): (&Axis, &Axis),
    occupied: &mut Occupied,
) -> Drawn {
    let Some((value, bar)) = error_of(run) else { return Ok(()) };
    let (at_x, at_y) = (x.place(run.cost), y.place(value));
    if let Some(bar) = bar {
        let ends = [y.place_end(value - bar), y.place_end(value + bar)];
        canvas.vertical_bar(at_x, ends, look.colour)?;
        occupied.add_line(&ends.map(|end| (at_x, end.at())));
    }
    if let Some(bar) = run.cost_error {
        let ends = [x.place_end(run.cost - bar), x.place_end(run.cost + bar)];
        canvas.horizontal_bar(at_y, ends, look.colour)?;
        occupied.add_line(&ends.map(|end| (end.at(), at_y)));
    }
    Ok(())
}

/// Draws a strip above the scale with a cross for each run without a result.
fn draw_failures(canvas: &Canvas<'_>, chart: &WorkPrecision, x: &Axis, top: f64) -> Drawn {
    let middle = top - STRIP_HEIGHT / 2.0;
    canvas.rectangle((x.start(), FRAME_TOP), (x.end(), top), STRIP)?;
    canvas.line(&[(x.start(), top), (x.end(), top)], FRAME, 0.8)?;
    canvas.text("failed", (x.start() - 9.0, middle), Anchor::Right, Type::new(12.0, SOFT))?;
    let mut occupied = Occupied::new(Block::new(x.start(), FRAME_TOP, x.end(), top));
    for (i, run) in failures(chart) {
        let at = (x.place(run.cost), middle);
        canvas.cross(at, 4.5, Look::of_series(i).colour)?;
        occupied.add(Block::around(at, 5.0));
        if let Some(label) = &run.label {
            let spot = occupied.place_text(label, 10.5, at);
            canvas.text(label, spot, Anchor::Middle, Type::new(10.5, INK))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn every_method_label_and_caption_is_in_the_picture_as_text() {
        let chart = samples::work_precision();
        let svg = work_precision(&chart).unwrap();
        for expected in ["Monte Carlo", "1,700", "failed", "CPU time (s)", "Example CPU", "10⁻³"]
        {
            assert!(svg.contains(expected), "{expected} is missing");
        }
    }

    #[test]
    fn the_data_survive_json() {
        let chart = samples::work_precision();
        let text = crate::finite::to_json(&chart).unwrap();
        assert_eq!(serde_json::from_str::<WorkPrecision>(&text).unwrap(), chart);
    }

    #[test]
    fn what_has_no_logarithm_is_refused() {
        let with = |cost: f64, value: f64| {
            let mut chart = samples::work_precision();
            chart.series[0].runs[0].cost = cost;
            chart.series[0].runs[0].outcome = RunOutcome::Error { value, standard_error: None };
            work_precision(&chart)
        };
        assert!(matches!(with(0.0, 1.0), Err(ChartError::NotPositive { quantity: "cost", .. })));
        assert!(matches!(with(1.0, 0.0), Err(ChartError::NotPositive { quantity: "error", .. })));
        assert!(matches!(
            with(1.0, f64::NAN),
            Err(ChartError::NotFinite { quantity: "error", .. })
        ));
    }

    #[test]
    fn a_chart_of_failures_alone_is_still_drawn_and_an_empty_one_is_not() {
        let mut chart = samples::work_precision();
        for run in chart.series.iter_mut().flat_map(|method| &mut method.runs) {
            run.outcome = RunOutcome::Failed { reason: "step collapsed".into() };
        }
        assert!(work_precision(&chart).is_ok());
        chart.series.clear();
        assert!(matches!(work_precision(&chart), Err(ChartError::Empty { .. })));
    }
}
