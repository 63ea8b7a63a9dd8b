//! Curves over a parameter, with thresholds and a strip for runs that ended in an error.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Drawn, FRAME, Look, SOFT, STRIP, Type, draw_svg};
use super::legend::{
    FRAME_TOP, FRAME_X, SHEET, Sample, draw_frame, draw_grid, draw_legend, draw_words, frame_bottom,
};
use crate::curve::{Curve, CurvePoint, Curves, Direction, Height, Style};
use crate::data::Scale;
use crate::error::{ChartError, check_finite};

const MARKER: f64 = 4.4;
/// Height of the strip for runs that ended in an error.
const STRIP_HEIGHT: f64 = 26.0;

/// Draws curves over a parameter as SVG.
///
/// # Errors
/// [`ChartError`] for a value that is not finite, a nonpositive abscissa on a logarithmic axis, or a chart without a
/// point.
pub fn curves(chart: &Curves) -> Result<String, ChartError> {
    check(chart)?;
    let mut words = chart.words.clone();
    let n_gaps = heights(chart).filter(|&y| !shown(chart.upwards, y)).count();
    if n_gaps > 0 {
        words.caption.push(format!(
            "{n_gaps} values of zero or below have no place on this scale and are not shown."
        ));
    }
    let bottom = frame_bottom(&words);
    let has_ended = points(chart).any(|point| matches!(point.height, Height::Ended { .. }));
    let top = if has_ended { FRAME_TOP + STRIP_HEIGHT } else { FRAME_TOP };
    let (x, y) = axes(chart, bottom, top);
    draw_svg(SHEET, &words.title, |canvas| {
        draw_words(canvas, &words, bottom)?;
        draw_grid(canvas, &x, &y)?;
        draw_thresholds(canvas, chart, &x, &y)?;
        for curve in &chart.series {
            draw_curve(canvas, chart, curve, &x, &y)?;
        }
        if has_ended {
            draw_ended(canvas, chart, &x, top)?;
        }
        draw_frame(canvas, &x, &y, FRAME_TOP)?;
        let sample = |curve: &Curve| {
            let look = Look::of_series(curve.look);
            match curve.style {
                Style::Line => Sample::Line(look),
                Style::Points => Sample::Points(look),
                Style::LineAndPoints => Sample::LineAndMarker(look),
            }
        };
        let named = chart.series.iter().filter(|curve| !curve.name.is_empty());
        let entries = named.map(|curve| (sample(curve), curve.name.as_str()));
        let thresholds = chart.thresholds.iter().enumerate();
        let thresholds = thresholds
            .map(|(i, threshold)| (Sample::Line(of_threshold(i)), threshold.name.as_str()));
        let ended =
            has_ended.then_some((Sample::Cross, "ended by a typed error, given in the JSON"));
        draw_legend(canvas, entries.chain(thresholds).chain(ended))
    })
}

fn axes(chart: &Curves, bottom: f64, top: f64) -> (Axis, Axis) {
    let of = |along: Direction| {
        let thresholds =
            chart.thresholds.iter().filter(move |threshold| threshold.direction == along);
        thresholds.map(|threshold| threshold.at)
    };
    let abscissas = points(chart).map(|point| point.x).chain(of(Direction::Across));
    let ends = points(chart).filter_map(|point| match point.height {
        Height::Value { y, bar } => {
            let bar = bar.unwrap_or(0.0);
            let low = if chart.upwards == Scale::Log { (y - bar).max(0.3 * y) } else { y - bar };
            Some([y, low, y + bar])
        }
        Height::Ended { .. } => None,
    });
    let ends = ends.flatten().chain(of(Direction::Upwards)).filter(|&y| shown(chart.upwards, y));
    let x = Axis::spanning(chart.across, abscissas, FRAME_X);
    (x, Axis::spanning(chart.upwards, ends, (bottom, top)))
}

/// Thresholds are grey and differ in their dashes.
fn of_threshold(index: usize) -> Look {
    Look { colour: SOFT, ..Look::of_series(index + 1) }
}

fn draw_thresholds(canvas: &Canvas<'_>, chart: &Curves, x: &Axis, y: &Axis) -> Drawn {
    for (i, threshold) in chart.thresholds.iter().enumerate() {
        let ends = match threshold.direction {
            Direction::Across => {
                let at = x.place(threshold.at);
                [(at, y.start()), (at, y.end())]
            }
            Direction::Upwards => {
                let at = y.place(threshold.at);
                [(x.start(), at), (x.end(), at)]
            }
        };
        canvas.dashed_line(&ends, of_threshold(i), 1.5)?;
    }
    Ok(())
}

fn draw_curve(canvas: &Canvas<'_>, chart: &Curves, curve: &Curve, x: &Axis, y: &Axis) -> Drawn {
    let look = Look::of_series(curve.look);
    let placed = |point: &CurvePoint| match point.height {
        Height::Value { y: value, .. } if shown(chart.upwards, value) => {
            Some((x.place(point.x), y.place(value)))
        }
        _ => None,
    };
    if curve.style != Style::Points {
        for piece in curve.points.split(|point| placed(point).is_none()) {
            let piece: Vec<(f64, f64)> = piece.iter().filter_map(placed).collect();
            canvas.dashed_line(&piece, look, 1.9)?;
        }
    }
    if curve.style == Style::Line {
        return Ok(());
    }
    for point in &curve.points {
        let Some(at) = placed(point) else { continue };
        if let Height::Value { y: value, bar: Some(bar) } = point.height {
            let ends = [y.place_end(value - bar), y.place_end(value + bar)];
            canvas.vertical_bar(at.0, ends, look.colour)?;
        }
        match curve.style {
            Style::Points => canvas.open_marker(at, look, MARKER)?,
            _ => canvas.marker(at, look, MARKER)?,
        }
    }
    Ok(())
}

/// Draws a strip above the scale with a cross for each run that ended in an error.
fn draw_ended(canvas: &Canvas<'_>, chart: &Curves, x: &Axis, top: f64) -> Drawn {
    let middle = top - STRIP_HEIGHT / 2.0;
    canvas.rectangle((x.start(), FRAME_TOP), (x.end(), top), STRIP)?;
    canvas.line(&[(x.start(), top), (x.end(), top)], FRAME, 0.8)?;
    canvas.text("ended", (x.start() - 9.0, middle), Anchor::Right, Type::new(12.0, SOFT))?;
    for curve in &chart.series {
        for point in &curve.points {
            if matches!(point.height, Height::Ended { .. }) {
                canvas.cross(
                    (x.place(point.x), middle),
                    4.5,
                    Look::of_series(curve.look).colour,
                )?;
            }
        }
    }
    Ok(())
}

fn shown(scale: Scale, value: f64) -> bool {
    scale == Scale::Linear || value > 0.0
}

fn points(chart: &Curves) -> impl Iterator<Item = &CurvePoint> {
    chart.series.iter().flat_map(|curve| &curve.points)
}

fn heights(chart: &Curves) -> impl Iterator<Item = f64> {
    points(chart).filter_map(|point| match point.height {
        Height::Value { y, .. } => Some(y),
        Height::Ended { .. } => None,
    })
}

fn check(chart: &Curves) -> Result<(), ChartError> {
    for curve in &chart.series {
        for point in &curve.points {
            let x = check_finite(&curve.name, "abscissa", point.x)?;
            if !shown(chart.across, x) {
                let series = curve.name.clone();
                return Err(ChartError::NotPositive { series, quantity: "abscissa", value: x });
            }
            if let Height::Value { y, bar } = point.height {
                check_finite(&curve.name, "value", y)?;
                check_finite(&curve.name, "error", bar.unwrap_or(0.0))?;
            }
        }
    }
    for threshold in &chart.thresholds {
        check_finite(&threshold.name, "threshold", threshold.at)?;
    }
    let is_empty = points(chart).next().is_none();
    if is_empty { Err(ChartError::Empty { title: chart.words.title.clone() }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Threshold, samples};

    fn chart(height: Height) -> Curves {
        let points = vec![
            CurvePoint::at(0.1, 1e-3),
            CurvePoint::sampled(1.0, 1e-2, 2e-3),
            CurvePoint { x: 10.0, height },
        ];
        let marked = Curve::marked("curve 1", 1, points.clone());
        let line = Curve { style: Style::Line, ..Curve::points("curve 0", 0, points) };
        Curves {
            words: samples::work_precision().words,
            across: Scale::Log,
            upwards: Scale::Log,
            series: vec![line, marked],
            thresholds: vec![Threshold::across("limit", 2.0)],
        }
    }

    #[test]
    fn what_ended_has_a_strip_and_the_data_survive_json() {
        let with = chart(Height::Ended { error: "too far".into() });
        let svg = curves(&with).unwrap();
        assert!(svg.contains("typed error") && svg.contains("limit") && svg.contains("curve 1"));
        let text = crate::finite::to_json(&with).unwrap();
        assert_eq!(serde_json::from_str::<Curves>(&text).unwrap(), with);
        let without = curves(&chart(Height::Value { y: 1.0, bar: None })).unwrap();
        assert!(!without.contains("typed error"));
    }

    #[test]
    fn what_has_no_logarithm_is_counted_above_and_refused_across() {
        let zero = chart(Height::Value { y: 0.0, bar: None });
        assert!(curves(&zero).unwrap().contains("2 values of zero or below"));
        let mut negative = zero;
        negative.series[0].points[0].x = 0.0;
        assert!(matches!(curves(&negative), Err(ChartError::NotPositive { .. })));
        let nan = chart(Height::Value { y: f64::NAN, bar: None });
        assert!(matches!(curves(&nan), Err(ChartError::NotFinite { .. })));
    }
}
