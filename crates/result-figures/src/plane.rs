//! A density over a plane, in bands of half a decade.

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Drawn, INK, Type, draw_svg};
use super::legend::{FRAME_TOP, FRAME_X, SHEET, draw_frame, draw_grid, draw_words, frame_bottom};
use crate::colours::mixed;
use crate::data::{Plane, Scale};
use crate::error::{ChartError, check_finite};

/// Bands below the peak, of half a decade each.
const BANDS: usize = 12;
/// Left edge of the colour key.
const KEY_X: f64 = 728.0;
/// Height of a band in the colour key.
const KEY_HEIGHT: f64 = 22.0;

/// Draws a density over a plane as SVG: darker is larger, white is below 1e-6 of the peak.
///
/// # Errors
/// [`ChartError`] for a value that is not finite, or a density that is nowhere positive.
pub fn plane(chart: &Plane) -> Result<String, ChartError> {
    let name = &chart.words.title;
    check_edges(name, &chart.x, &chart.y)?;
    let mut peak = 0.0_f64;
    for &value in chart.values.iter().flatten() {
        peak = peak.max(check_finite(name, "density", value)?);
    }
    if peak <= 0.0 || chart.x.len() < 2 || chart.y.len() < 2 {
        return Err(ChartError::Empty { title: name.clone() });
    }
    let bottom = frame_bottom(&chart.words);
    let x = Axis::spanning(Scale::Linear, chart.x.iter().copied(), FRAME_X);
    let y = Axis::spanning(Scale::Linear, chart.y.iter().copied(), (bottom, FRAME_TOP));
    draw_svg(SHEET, name, |canvas| {
        draw_words(canvas, &chart.words, bottom)?;
        draw_grid(canvas, &x, &y)?;
        for (k, row) in chart.values.iter().enumerate() {
            let ends = (y.place(chart.y[k]), y.place(chart.y[k + 1]));
            let bands: Vec<_> = row.iter().map(|&value| band(value, peak)).collect();
            draw_row(canvas, &bands, |column| x.place(chart.x[column]), ends, colour)?;
        }
        draw_frame(canvas, &x, &y, FRAME_TOP)?;
        draw_key(canvas)
    })
}

/// Checks the edges of the cells of a plane.
pub(super) fn check_edges(name: &str, x: &[f64], y: &[f64]) -> Result<(), ChartError> {
    for (quantity, values) in [("abscissa", x), ("ordinate", y)] {
        for &value in values {
            check_finite(name, quantity, value)?;
        }
    }
    Ok(())
}

/// Draws neighbouring cells of the same band as one rectangle.
pub(super) fn draw_row(
    canvas: &Canvas<'_>,
    row: &[Option<usize>],
    edge: impl Fn(usize) -> f64,
    (low, high): (f64, f64),
    colour: impl Fn(usize) -> RGBColor,
) -> Drawn {
    let mut start = 0;
    for cells in row.chunk_by(|a, b| a == b) {
        let end = start + cells.len();
        if let Some(band) = cells[0] {
            canvas.rectangle((edge(start), high), (edge(end), low), colour(band))?;
        }
        start = end;
    }
    Ok(())
}

fn draw_key(canvas: &Canvas<'_>) -> Drawn {
    let face = Type::new(12.0, INK);
    canvas.text("part of the peak", (KEY_X, FRAME_TOP + 8.0), Anchor::Left, face)?;
    for band in 0..BANDS {
        let top = FRAME_TOP + 24.0 + KEY_HEIGHT * band as f64;
        canvas.rectangle((KEY_X, top), (KEY_X + 30.0, top + KEY_HEIGHT), colour(band))?;
        if band % 2 == 0 {
            let text = if band == 0 { "1".to_owned() } else { format!("1e-{}", band / 2) };
            canvas.text(&text, (KEY_X + 38.0, top), Anchor::Left, face)?;
        }
    }
    Ok(())
}

/// Band of a value, 0 at the peak; none below the last band.
fn band(value: f64, peak: f64) -> Option<usize> {
    let below = -2.0 * (value / peak).log10();
    (0..BANDS).find(|&band| below < band as f64 + 1.0)
}

/// From dark blue to nearly white.
fn colour(band: usize) -> RGBColor {
    mixed((8.0, 40.0, 92.0), (236.0, 243.0, 250.0), band as f64 / BANDS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::named;

    fn bump() -> Plane {
        let edges: Vec<f64> = (0..=20).map(|k| -2.0 + 0.2 * f64::from(k)).collect();
        let value = |x: f64, y: f64| (-4.0 * (x * x + y * y)).exp();
        let middles: Vec<f64> = edges.windows(2).map(|e| f64::midpoint(e[0], e[1])).collect();
        let values = middles.iter().map(|&y| middles.iter().map(|&x| value(x, y)).collect());
        Plane { words: named("bump"), x: edges.clone(), y: edges.clone(), values: values.collect() }
    }

    #[test]
    fn bands_are_half_decades_below_the_peak() {
        assert_eq!(band(2.0, 2.0), Some(0));
        // log10(0.3) = -0.52, log10(0.011) = -1.96.
        assert_eq!((band(0.3, 1.0), band(0.011, 1.0)), (Some(1), Some(3)));
        assert_eq!((band(0.9e-6, 1.0), band(0.0, 1.0)), (None, None));
    }

    #[test]
    fn a_bump_is_drawn_dark_in_its_middle_and_nan_is_refused() {
        let svg = plane(&bump()).unwrap();
        assert!(svg.contains("bump") && svg.to_uppercase().contains("#08285C"), "no dark band");
        let mut broken = bump();
        broken.values[3][4] = f64::NAN;
        assert!(matches!(plane(&broken), Err(ChartError::NotFinite { quantity: "density", .. })));
        broken.values = vec![vec![0.0; 20]; 20];
        assert!(matches!(plane(&broken), Err(ChartError::Empty { .. })));
    }
}
