//! A probability over a plane, and the quantiles of a path on it.

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Drawn, GROUND, INK, Look, Marker, SOFT, Type, draw_svg};
use super::legend::{FRAME_TOP, FRAME_X, SHEET, draw_frame, draw_words, frame_bottom};
use super::plane::draw_row;
use crate::colours::{Rgb, of_band};
use crate::data::{PathMap, Scale};
use crate::error::{ChartError, check_finite};

/// Steps of the colour scale.
const BANDS: usize = 16;
/// Height of a band in the colour key.
const KEY_HEIGHT: f64 = 14.0;
/// Distance from the frame to the colour key.
const KEY_GAP: f64 = 22.0;
/// Largest height of the frame.
const MOST_HEIGHT: f64 = 560.0;
/// Smallest height of the frame, required by the colour key.
const LEAST_HEIGHT: f64 = 390.0;

/// From nearly white over orange to dark brown (after YlOrBr, Brewer 2003).
const COLOURS: [Rgb; 5] = [
    (255.0, 253.0, 244.0),
    (254.0, 227.0, 145.0),
    (251.0, 154.0, 41.0),
    (204.0, 76.0, 2.0),
    (90.0, 30.0, 6.0),
];
/// Colour of the path.
const PATH: RGBColor = RGBColor(0, 92, 170);
/// Half the width of the light rim around the path.
const RIM: f64 = 1.2;

/// Draws the map as SVG.
///
/// # Errors
/// [`ChartError`] for a value that is not finite, or a map without a cell.
pub fn path_map(chart: &PathMap) -> Result<String, ChartError> {
    check(chart)?;
    let (width, height) = (extent(&chart.x), extent(&chart.y));
    let wide = FRAME_X.1 - FRAME_X.0;
    // The margins of both axes are the same fraction of their lengths, so both keep the same scale.
    let tall = (wide * height / width).min(MOST_HEIGHT);
    let right = FRAME_X.0 + tall * width / height;
    let bottom = FRAME_TOP + tall;
    let sheet =
        (SHEET.0, SHEET.1 + (FRAME_TOP + tall.max(LEAST_HEIGHT)) - frame_bottom(&chart.words));
    let x = Axis::spanning(Scale::Linear, chart.x.iter().copied(), (FRAME_X.0, right));
    let y = Axis::spanning(Scale::Linear, chart.y.iter().copied(), (bottom, FRAME_TOP));
    let (x_label, y_label) = (String::new(), String::new());
    let words = super::Words { x_label, y_label, ..chart.words.clone() };
    draw_svg(sheet, &chart.words.title, |canvas| {
        draw_words(canvas, &words, FRAME_TOP + tall.max(LEAST_HEIGHT))?;
        let middle = (f64::midpoint(FRAME_X.0, right), bottom + 42.0);
        canvas.text(&chart.words.x_label, middle, Anchor::Middle, Type::new(13.5, INK))?;
        let upwards = (26.0, f64::midpoint(FRAME_TOP, bottom));
        canvas.text(&chart.words.y_label, upwards, Anchor::Upwards, Type::new(13.5, INK))?;
        draw_cells(canvas, chart, &x, &y)?;
        draw_path(canvas, chart, &x, &y)?;
        draw_frame(canvas, &x, &y, FRAME_TOP)?;
        draw_key(canvas, chart, right + KEY_GAP)
    })
}

fn check(chart: &PathMap) -> Result<(), ChartError> {
    let name = &chart.words.title;
    let curves = chart.quantiles.iter().map(|quantile| &quantile.points).chain([&chart.given.1]);
    let places = curves.flatten().flatten();
    for &value in chart.x.iter().chain(&chart.y).chain(places) {
        check_finite(name, "coordinate", value)?;
    }
    for &value in chart.values.iter().flatten().flatten() {
        check_finite(name, "value", value)?;
    }
    if chart.x.len() < 2 || chart.y.len() < 2 || extent(&chart.x) <= 0.0 || extent(&chart.y) <= 0.0
    {
        return Err(ChartError::Empty { title: name.clone() });
    }
    Ok(())
}

fn extent(edges: &[f64]) -> f64 {
    edges.last().zip(edges.first()).map_or(0.0, |(last, first)| last - first)
}

fn draw_cells(canvas: &Canvas<'_>, chart: &PathMap, x: &Axis, y: &Axis) -> Drawn {
    for (k, row) in chart.values.iter().enumerate() {
        let ends = (y.place(chart.y[k]), y.place(chart.y[k + 1]));
        let bands: Vec<_> = row.iter().map(|value| value.map(band)).collect();
        draw_row(canvas, &bands, |column| x.place(chart.x[column]), ends, colour)?;
    }
    let [left, right] = [&chart.x[0], &chart.x[chart.x.len() - 1]].map(|&edge| x.place(edge));
    let [low, high] = [&chart.y[0], &chart.y[chart.y.len() - 1]].map(|&edge| y.place(edge));
    canvas.line(&[(left, low), (right, low), (right, high), (left, high), (left, low)], SOFT, 0.8)
}

/// Draws the quantiles with a light rim, visible on any colour.
fn draw_path(canvas: &Canvas<'_>, chart: &PathMap, x: &Axis, y: &Axis) -> Drawn {
    let on_sheet = |points: &[[f64; 2]]| -> Vec<(f64, f64)> {
        points.iter().map(|&[a, b]| (x.place(a), y.place(b))).collect()
    };
    if let (Some(low), Some(high)) = (chart.quantiles.first(), chart.quantiles.last()) {
        let above = on_sheet(&high.points).into_iter().rev();
        let outline: Vec<_> = on_sheet(&low.points).into_iter().chain(above).collect();
        canvas.veil(&outline, PATH)?;
    }
    for (k, quantile) in chart.quantiles.iter().enumerate() {
        let (look, width) = look(k, chart.quantiles.len());
        let points = on_sheet(&quantile.points);
        if look.dashes.is_empty() {
            canvas.line(&points, GROUND, width + 2.0 * RIM)?;
        }
        canvas.dashed_line(&points, look, width)?;
    }
    let given = on_sheet(&chart.given.1);
    canvas.line(&given, GROUND, 4.0 + 2.0 * RIM)?;
    canvas.line(&given, INK, 4.0)
}

/// The middle quantile is bold, the outermost ones are dashed.
fn look(k: usize, n: usize) -> (Look, f64) {
    let of = |dashes| Look { colour: PATH, marker: Marker::Circle, dashes };
    if 2 * k + 1 == n {
        (of(&[]), 2.6)
    } else if k == 0 || k + 1 == n {
        (of(&[7.0, 3.5]), 1.6)
    } else {
        (of(&[2.0, 2.5]), 1.4)
    }
}

/// Draws the colour key: largest value at the top, the path below.
fn draw_key(canvas: &Canvas<'_>, chart: &PathMap, left: f64) -> Drawn {
    let face = Type::new(12.0, INK);
    let mut top = FRAME_TOP + 8.0;
    for line in &chart.probability {
        canvas.text(line, (left, top), Anchor::Left, face)?;
        top += 15.0;
    }
    let top_of = |k: usize| top + KEY_HEIGHT * k as f64;
    for k in 0..BANDS {
        let fill = colour(BANDS - 1 - k);
        canvas.rectangle((left, top_of(k)), (left + 28.0, top_of(k + 1)), fill)?;
    }
    for k in (0..=BANDS).step_by(BANDS / 4) {
        let value = 1.0 - k as f64 / BANDS as f64;
        canvas.text(&format!("{value}"), (left + 36.0, top_of(k)), Anchor::Left, face)?;
    }
    let mut y = top_of(BANDS) + 30.0;
    let (name, _) = &chart.given;
    canvas.line(&[(left, y), (left + 28.0, y)], INK, 4.0)?;
    canvas.text(name, (left + 36.0, y), Anchor::Left, face)?;
    for (k, quantile) in chart.quantiles.iter().enumerate().rev() {
        y += 20.0;
        let (look, width) = look(k, chart.quantiles.len());
        canvas.dashed_line(&[(left, y), (left + 28.0, y)], look, width)?;
        canvas.text(&quantile.name, (left + 36.0, y), Anchor::Left, face)?;
    }
    Ok(())
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 1")]
fn band(value: f64) -> usize {
    ((value.clamp(0.0, 1.0) * BANDS as f64) as usize).min(BANDS - 1)
}

/// Colour of a band.
fn colour(band: usize) -> RGBColor {
    of_band(&COLOURS, band, BANDS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PathQuantile;
    use crate::samples::named;

    fn map() -> PathMap {
        let quantile = |name: &str, height: f64| PathQuantile {
            name: name.into(),
            points: vec![[0.5, height], [2.0, height]],
        };
        PathMap {
            words: named("map"),
            probability: vec!["probability".into(), "of damage".into()],
            x: vec![0.0, 1.0, 2.0],
            y: vec![0.0, 1.0],
            values: vec![vec![Some(0.0), Some(1.0)]],
            given: ("notch".into(), vec![[0.0, 0.5], [0.5, 0.5]]),
            quantiles: vec![quantile("5 %", 0.4), quantile("median", 0.5), quantile("95 %", 0.6)],
        }
    }

    #[test]
    fn never_and_always_have_the_end_colours_and_the_key_names_the_path() {
        let svg = path_map(&map()).unwrap().to_uppercase();
        for expected in ["#FFFDF4", "#5A1E06", "OF DAMAGE", "MEDIAN", "95 %", "NOTCH", "X (M)"] {
            assert!(svg.contains(expected), "{expected} is missing");
        }
    }

    #[test]
    fn both_axes_have_one_scale() {
        for (width, height) in [(1.0, 1.0), (5.0, 1.0), (1.0, 3.0)] {
            let mut map = map();
            (map.x, map.y) = (vec![0.0, width], vec![0.0, height]);
            map.values = vec![vec![Some(1.0)]];
            map.quantiles.clear();
            let svg = path_map(&map).unwrap();
            // The only cell of probability one, unlike its entry in the key, has the aspect ratio of the body.
            let cells = svg.lines().filter(|line| line.to_uppercase().contains("#5A1E06"));
            let side = |line: &str, name: &str| -> f64 {
                let rest = line.split(&format!("{name}=\"")).nth(1).unwrap();
                rest.split('"').next().unwrap().parse().unwrap()
            };
            let cell =
                cells.max_by(|a, b| side(a, " width").total_cmp(&side(b, " width"))).unwrap();
            let ratio = side(cell, " width") / side(cell, " height");
            // Positions are rounded to a quarter of a unit, out of some hundred.
            assert!((ratio / (width / height) - 1.0).abs() < 0.01, "{ratio}");
        }
    }

    #[test]
    fn nan_is_refused_and_so_is_nothing() {
        let mut broken = map();
        broken.values[0][0] = Some(f64::NAN);
        assert!(matches!(path_map(&broken), Err(ChartError::NotFinite { quantity: "value", .. })));
        broken = map();
        broken.x.clear();
        assert!(matches!(path_map(&broken), Err(ChartError::Empty { .. })));
    }
}
