//! A quantity over the cells of a plane on a linear scale, with named regions.

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Drawn, INK, Type, draw_svg};
use super::legend::{FRAME_TOP, FRAME_X, SHEET, draw_frame, draw_grid, draw_words, frame_bottom};
use super::plane::{check_edges, draw_row};
use crate::colours::{Rgb, of_band};
use crate::data::{Field, Scale};
use crate::error::{ChartError, check_finite};

/// Steps of the colour scale.
const BANDS: usize = 16;
/// Left edge of the colour key.
const KEY_X: f64 = 728.0;
/// Height of a band in the colour key.
const KEY_HEIGHT: f64 = 16.0;

/// From violet over green to yellow, in equal steps of lightness (after viridis, Smith and van der Walt 2015).
const COLOURS: [Rgb; 5] = [
    (68.0, 1.0, 84.0),
    (59.0, 82.0, 139.0),
    (33.0, 145.0, 140.0),
    (94.0, 201.0, 98.0),
    (253.0, 231.0, 37.0),
];
/// Colours of the named regions.
const PALE: [RGBColor; 3] =
    [RGBColor(222, 235, 247), RGBColor(252, 228, 214), RGBColor(230, 230, 230)];

/// Draws a field as SVG.
///
/// # Errors
/// [`ChartError`] for a value that is not finite, or a field without a value.
pub fn field(chart: &Field) -> Result<String, ChartError> {
    let name = &chart.words.title;
    check_edges(name, &chart.x, &chart.y)?;
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in chart.values.iter().flatten().filter_map(|&value| value) {
        check_finite(name, "value", value)?;
        (least, most) = (least.min(value), most.max(value));
    }
    if least > most || chart.x.len() < 2 || chart.y.len() < 2 {
        return Err(ChartError::Empty { title: name.clone() });
    }
    let scale = Colours { least, most };
    let bottom = frame_bottom(&chart.words);
    let x = Axis::spanning(Scale::Linear, chart.x.iter().copied(), FRAME_X);
    let y = Axis::spanning(Scale::Linear, chart.y.iter().copied(), (bottom, FRAME_TOP));
    let edge = |column: usize| x.place(chart.x[column]);
    draw_svg(SHEET, name, |canvas| {
        draw_words(canvas, &chart.words, bottom)?;
        draw_grid(canvas, &x, &y)?;
        for (k, row) in chart.values.iter().enumerate() {
            let ends = (y.place(chart.y[k]), y.place(chart.y[k + 1]));
            for (region, pale) in chart.regions.iter().zip(PALE.iter().cycle()) {
                let cells: Vec<_> = region.cells[k].iter().map(|&is| is.then_some(0)).collect();
                draw_row(canvas, &cells, edge, ends, |_| *pale)?;
            }
            let bands: Vec<_> = row.iter().map(|value| value.map(|v| scale.band(v))).collect();
            draw_row(canvas, &bands, edge, ends, colour)?;
        }
        draw_frame(canvas, &x, &y, FRAME_TOP)?;
        draw_key(canvas, chart, &scale)
    })
}

/// The colour scale.
struct Colours {
    least: f64,
    most: f64,
}

impl Colours {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 1")]
    fn band(&self, value: f64) -> usize {
        let part = if self.most > self.least {
            (value - self.least) / (self.most - self.least)
        } else {
            0.0
        };
        ((part * BANDS as f64) as usize).min(BANDS - 1)
    }
}

/// Draws the colour key: largest value at the top, regions below.
fn draw_key(canvas: &Canvas<'_>, chart: &Field, scale: &Colours) -> Drawn {
    let face = Type::new(12.0, INK);
    canvas.text(&chart.unit, (KEY_X, FRAME_TOP + 8.0), Anchor::Left, face)?;
    let top_of = |k: usize| FRAME_TOP + 24.0 + KEY_HEIGHT * k as f64;
    for k in 0..BANDS {
        let (top, band) = (top_of(k), BANDS - 1 - k);
        canvas.rectangle((KEY_X, top), (KEY_X + 30.0, top + KEY_HEIGHT), colour(band))?;
    }
    for k in (0..=BANDS).step_by(4) {
        let part = 1.0 - k as f64 / BANDS as f64;
        let value = scale.least + part * (scale.most - scale.least);
        // A millionth of a band is not seen.
        let is_zero = value.abs() < 1e-6 * (scale.most - scale.least) / BANDS as f64;
        let value = if is_zero { 0.0 } else { value };
        canvas.text(&three_digits(value), (KEY_X + 38.0, top_of(k)), Anchor::Left, face)?;
    }
    for (r, (region, pale)) in chart.regions.iter().zip(PALE.iter().cycle()).enumerate() {
        let top = top_of(BANDS) + 20.0 + 24.0 * r as f64;
        canvas.rectangle((KEY_X, top), (KEY_X + 30.0, top + KEY_HEIGHT), *pale)?;
        let middle = top + 0.5 * KEY_HEIGHT;
        canvas.text(&region.name, (KEY_X + 38.0, middle), Anchor::Left, face)?;
    }
    Ok(())
}

/// Formats a number of the key with at least three digits.
fn three_digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 0.1 => format!("{value:.2}"),
        _ => format!("{value:.1e}"),
    }
}

/// Colour of a band.
fn colour(band: usize) -> RGBColor {
    of_band(&COLOURS, band, BANDS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::samples::named;

    fn ramp() -> Field {
        Field {
            words: named("ramp"),
            unit: "flow stress (MPa)".into(),
            x: vec![0.0, 1.0, 2.0, 3.0],
            y: vec![0.0, 1.0],
            values: vec![vec![Some(10.0), Some(30.0), None]],
            regions: vec![Region { name: "water".into(), cells: vec![vec![false, false, true]] }],
        }
    }

    #[test]
    fn ends_of_the_scale_have_its_end_colours_and_the_key_says_all() {
        let svg = field(&ramp()).unwrap().to_uppercase();
        for expected in ["#440154", "#FDE725", "#DEEBF7", "WATER", "FLOW STRESS (MPA)", "30.0"] {
            assert!(svg.contains(expected), "{expected} is missing");
        }
    }

    #[test]
    fn an_end_that_is_zero_but_for_roundoff_is_zero_in_the_key() {
        let mut still = ramp();
        still.values = vec![vec![Some(3e-22), Some(30.0), None]];
        let svg = field(&still).unwrap();
        assert!(svg.contains(">0</text>") || svg.contains("\n0\n"), "{svg}");
        assert!(!svg.contains("e-22"));
    }

    #[test]
    fn nan_is_refused_and_so_is_nothing() {
        let mut broken = ramp();
        broken.values[0][0] = Some(f64::NAN);
        assert!(matches!(field(&broken), Err(ChartError::NotFinite { quantity: "value", .. })));
        broken.values = vec![vec![None; 3]];
        assert!(matches!(field(&broken), Err(ChartError::Empty { .. })));
    }
}
