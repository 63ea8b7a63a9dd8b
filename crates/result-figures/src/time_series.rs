//! Values over time, with reference points.

use super::axis::Axis;
use super::canvas::{Canvas, Drawn, INK, Look, draw_svg};
use super::legend::{
    FRAME_TOP, FRAME_X, SHEET, Sample, draw_frame, draw_grid, draw_legend, draw_words, frame_bottom,
};
use crate::data::{ReferencePoint, Scale, TimeSeries};
use crate::error::{ChartError, check_finite};

/// Draws values over time as SVG.
///
/// # Errors
/// [`ChartError`] for a value that is not finite, or a chart without a point.
pub fn time_series(chart: &TimeSeries) -> Result<String, ChartError> {
    check(chart)?;
    let mut words = chart.words.clone();
    let n_gaps = values(chart).filter(|&(_, y)| !shown(chart.scale, y)).count();
    if n_gaps > 0 {
        words.caption.push(format!(
            "{n_gaps} values of zero or below have no place on this scale and are not shown."
        ));
    }
    let bottom = frame_bottom(&words);
    let x = Axis::spanning(Scale::Linear, values(chart).map(|(x, _)| x), FRAME_X);
    let heights =
        values(chart).map(|(_, y)| y).chain(bar_ends(chart)).filter(|&y| shown(chart.scale, y));
    let y = Axis::spanning(chart.scale, heights, (bottom, FRAME_TOP));
    draw_svg(SHEET, &words.title, |canvas| {
        draw_words(canvas, &words, bottom)?;
        draw_grid(canvas, &x, &y)?;
        for (i, band) in chart.bands.iter().enumerate() {
            let shown = band.points.iter().filter(|&&(_, low, _)| shown(chart.scale, low));
            let above = shown.clone().map(|&(at, _, high)| (x.place(at), y.place(high)));
            let below = shown.rev().map(|&(at, low, _)| (x.place(at), y.place(low)));
            let outline: Vec<(f64, f64)> = above.chain(below).collect();
            canvas.veil(&outline, Look::of_series(i).colour)?;
        }
        for (i, line) in chart.lines.iter().enumerate() {
            // A missing value ends one segment and begins the next.
            let drawn = |value: Option<f64>| value.filter(|&value| shown(chart.scale, value));
            for piece in line.points.split(|&(_, value)| drawn(value).is_none()) {
                let piece: Vec<(f64, f64)> = piece
                    .iter()
                    .filter_map(|&(at, value)| Some((x.place(at), y.place(value?))))
                    .collect();
                canvas.dashed_line(&piece, Look::of_series(i), 2.0)?;
            }
        }
        for (i, set) in chart.references.iter().enumerate() {
            for point in set.points.iter().filter(|point| shown(chart.scale, point.y)) {
                draw_reference(canvas, point, reference_look(i), &x, &y)?;
            }
        }
        draw_frame(canvas, &x, &y, FRAME_TOP)?;
        let lines = chart.lines.iter().enumerate();
        let lines = lines.map(|(i, line)| (Sample::Line(Look::of_series(i)), line.name.as_str()));
        let references = chart.references.iter().enumerate();
        let references =
            references.map(|(i, set)| (Sample::Points(reference_look(i)), set.name.as_str()));
        draw_legend(canvas, lines.chain(references))
    })
}

/// References are dark in every series and differ in their markers.
fn reference_look(index: usize) -> Look {
    Look { colour: INK, ..Look::of_series(index) }
}

fn draw_reference(
    canvas: &Canvas<'_>,
    point: &ReferencePoint,
    look: Look,
    x: &Axis,
    y: &Axis,
) -> Drawn {
    let at = (x.place(point.x), y.place(point.y));
    if let Some(error) = point.error {
        let ends = [y.place_end(point.y - error), y.place_end(point.y + error)];
        canvas.vertical_bar(at.0, ends, look.colour)?;
    }
    canvas.open_marker(at, look, 4.8)
}

fn shown(scale: Scale, value: f64) -> bool {
    scale == Scale::Linear || value > 0.0
}

fn values(chart: &TimeSeries) -> impl Iterator<Item = (f64, f64)> {
    let computed =
        chart.lines.iter().flat_map(|line| line.points.iter().filter_map(|&(x, y)| Some((x, y?))));
    let ends = |&(x, low, high): &(f64, f64, f64)| [(x, low), (x, high)];
    computed
        .chain(chart.bands.iter().flat_map(|band| &band.points).flat_map(ends))
        .chain(chart.references.iter().flat_map(|set| &set.points).map(|point| (point.x, point.y)))
}

/// Upper ends on either scale; lower ends unless they would span decades by themselves.
fn bar_ends(chart: &TimeSeries) -> impl Iterator<Item = f64> {
    let floor = move |point: &ReferencePoint, low: f64| match chart.scale {
        Scale::Linear => low,
        Scale::Log => low.max(0.3 * point.y),
    };
    chart.references.iter().flat_map(|set| &set.points).flat_map(move |point| {
        let error = point.error.unwrap_or(0.0);
        [point.y + error, floor(point, point.y - error)]
    })
}

fn check(chart: &TimeSeries) -> Result<(), ChartError> {
    for line in &chart.lines {
        for &(x, y) in &line.points {
            check_finite(&line.name, "time", x)?;
            check_finite(&line.name, "value", y.unwrap_or(0.0))?;
        }
    }
    for &(x, low, high) in chart.bands.iter().flat_map(|band| &band.points) {
        check_finite("a band", "time", x)?;
        check_finite("a band", "lower end", low)?;
        check_finite("a band", "upper end", high)?;
    }
    for set in &chart.references {
        for point in &set.points {
            check_finite(&set.name, "time", point.x)?;
            check_finite(&set.name, "value", point.y)?;
            check_finite(&set.name, "error", point.error.unwrap_or(0.0))?;
        }
    }
    let has_points = values(chart).any(|(_, y)| shown(chart.scale, y));
    if has_points { Ok(()) } else { Err(ChartError::Empty { title: chart.words.title.clone() }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn both_scales_are_drawn_and_the_data_survive_json() {
        for scale in [Scale::Linear, Scale::Log] {
            let chart = samples::time_series(scale);
            let svg = time_series(&chart).unwrap();
            assert!(svg.contains("closed form") && svg.contains("time (s)"));
            let text = crate::finite::to_json(&chart).unwrap();
            assert_eq!(serde_json::from_str::<TimeSeries>(&text).unwrap(), chart);
        }
    }

    #[test]
    fn values_without_a_logarithm_are_counted_in_the_foot() {
        let mut chart = samples::time_series(Scale::Log);
        chart.lines[0].points[0].1 = Some(0.0);
        chart.lines[0].points[1].1 = Some(0.0);
        assert!(time_series(&chart).unwrap().contains("2 values of zero or below"));
    }

    #[test]
    fn nan_is_refused_and_so_is_nothing() {
        let mut chart = samples::time_series(Scale::Linear);
        chart.lines[0].points[3].1 = Some(f64::NAN);
        assert!(matches!(
            time_series(&chart),
            Err(ChartError::NotFinite { quantity: "value", .. })
        ));
        chart.lines.clear();
        chart.references.clear();
        assert!(matches!(time_series(&chart), Err(ChartError::Empty { .. })));
    }
}
