//! Interpolation between given colours.

use plotters::style::RGBColor;

/// Red, green and blue, each from 0 to 255.
pub(crate) type Rgb = (f64, f64, f64);

/// The colour of a band out of `bands`, from the first colour to the last.
pub(crate) fn of_band(colours: &[Rgb], band: usize, bands: usize) -> RGBColor {
    let place = band as f64 / (bands - 1) as f64 * (colours.len() - 1) as f64;
    let lower = (0..colours.len() - 1).rev().find(|&k| k as f64 <= place).unwrap_or(0);
    mixed(colours[lower], colours[lower + 1], place - lower as f64)
}

/// Interpolates from `from` at `part = 0` to `to` at 1.
pub(crate) fn mixed(from: Rgb, to: Rgb, part: f64) -> RGBColor {
    let mix = |a: f64, b: f64| {
        let value = a + part * (b - a);
        (0..=255_u8).find(|&level| f64::from(level) + 0.5 >= value).unwrap_or(255)
    };
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}
