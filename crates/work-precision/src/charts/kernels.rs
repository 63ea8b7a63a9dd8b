//! Comparison of kernels: values and slopes at equal support, Fourier transforms at equal spread.

use std::f64::consts::PI;

use result_figures::{Drawing, Line, Scale, TimeSeries, Words};
use smoothing_kernels::{Kernel, all};

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "kernels",
    title: "every smoothing kernel: value, slope, Fourier transform",
    draw,
};

/// Points along a curve.
const POINTS: u32 = 400;

/// Smallest value of a transform that is drawn; the error of its integral is below 1e-10.
const SMALLEST_TRANSFORM: f64 = 1e-7;

fn draw(_: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let value = |kernel: &dyn Kernel<2>, r: f64, h: f64| kernel.value(r, h);
    let slope = |kernel: &dyn Kernel<2>, r: f64, h: f64| kernel.radial_derivative(r, h);
    Ok(vec![
        at_equal_support(
            "kernels-value",
            "Smoothing kernels in 2-D at equal support",
            "W R²",
            value,
        )?,
        at_equal_support(
            "kernels-slope",
            "Slopes of the smoothing kernels in 2-D at equal support",
            "dW/dr R³",
            slope,
        )?,
        transforms()?,
    ])
}

fn at_equal_support(
    name: &str,
    title: &str,
    y_label: &str,
    of: impl Fn(&dyn Kernel<2>, f64, f64) -> f64,
) -> Result<Drawing, CaseError> {
    let lines = all::<2>()
        .into_iter()
        .map(|(name, kernel)| {
            // A support radius of one.
            let h = 1.0 / kernel.support();
            let spread = kernel.second_moment().sqrt() * h;
            let at = |k: u32| f64::from(k) / f64::from(POINTS);
            Line {
                name: format!("{name}, s/R={spread:.2}"),
                points: (0..=POINTS)
                    .map(|k| (at(k), Some(of(kernel.as_ref(), at(k), h))))
                    .collect(),
            }
        })
        .collect();
    let words = Words {
        title: title.into(),
        subtitle: "R is the support radius, s the standard deviation of one coordinate; every kernel integrates to one"
            .into(),
        x_label: "distance over support radius, r / R".into(),
        y_label: y_label.into(),
        caption: Vec::new(),
    };
    let data = TimeSeries {
        words,
        scale: Scale::Linear,
        lines,
        bands: Vec::new(),
        references: Vec::new(),
    };
    Ok(Drawing::time_series(name, &data)?)
}

/// Chart of the transforms; a line has a gap where the transform is negative or too small.
fn transforms() -> Result<Drawing, CaseError> {
    let lines = all::<3>()
        .into_iter()
        .map(|(name, kernel)| {
            let spread = kernel.second_moment().sqrt();
            let at = |k: u32| 14.0 * f64::from(k) / f64::from(POINTS);
            let value = |wave: f64| {
                let value = transform(kernel.as_ref(), wave / spread);
                (value > SMALLEST_TRANSFORM).then_some(value)
            };
            let points = (0..=POINTS).map(|k| (at(k), value(at(k)))).collect();
            Line { name: name.into(), points }
        })
        .collect();
    let words = Words {
        title: "Fourier transforms of the smoothing kernels in 3-D at equal spread".into(),
        subtitle: "k is the wave number, s the standard deviation of one coordinate; one at k = 0".into(),
        x_label: "wave number times standard deviation, k s".into(),
        y_label: "Fourier transform of W".into(),
        caption: vec![
            "Gaps: the transform is negative, and particles with many neighbours may pair; or below 1e-7. \
             Of the Wendland functions no transform is negative."
                .into(),
        ],
    };
    let data =
        TimeSeries { words, scale: Scale::Log, lines, bands: Vec::new(), references: Vec::new() };
    Ok(Drawing::time_series("kernels-transform", &data)?)
}

/// `4π σ / k ∫ w(q) q sin(k q) dq`, the transform of a radial function in space, for `h = 1`.
fn transform(kernel: &dyn Kernel<3>, k: f64) -> f64 {
    // Simpson's rule; 6000 panels end at every knot, and no wave is shorter than 600 of them.
    const PANELS: u32 = 6000;
    let width = kernel.support() / f64::from(PANELS);
    let integrand = |q: f64| {
        let wave = if k > 0.0 { (k * q).sin() / k } else { q };
        kernel.shape(q) * q * wave
    };
    let sum: f64 = (0..PANELS)
        .map(|panel| {
            let start = f64::from(panel) * width;
            // Up to the edge but excluding it, where a truncated kernel is already zero.
            let end = (start + width) * (1.0 - f64::EPSILON);
            integrand(start) + 4.0 * integrand(start + 0.5 * width) + integrand(end)
        })
        .sum();
    4.0 * PI * kernel.normalisation() * sum * width / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transform_begins_at_one_and_falls_with_the_second_moment() {
        for (name, kernel) in all::<3>() {
            assert!((transform(kernel.as_ref(), 0.0) - 1.0).abs() < 1e-10, "{name}");
            // 1 - kappa k^2 / 2 + O(k^4).
            let fallen = 1.0 - transform(kernel.as_ref(), 1e-2);
            let expected = 0.5 * kernel.second_moment() * 1e-4;
            assert!((fallen / expected - 1.0).abs() < 1e-3, "{name}: {fallen} {expected}");
        }
    }

    #[test]
    fn transform_of_the_cubic_spline_is_the_published_one() {
        // Monaghan 1985 gives the spline's transform in one dimension, (sin(k/2) / (k/2))^4; in space it is -1/(2π k)
        // times the slope of the transform of W as a function on the line, whose unnormalised integral is 3/2.
        let line = |k: f64| ((0.5 * k).sin() / (0.5 * k)).powi(4);
        for k in [1.0, 3.0, 7.0, 9.0] {
            let slope = (line(k + 1e-5) - line(k - 1e-5)) / 2e-5;
            // ∫ w cos(kq) dq over the line is 3/2 line(k); its slope is -2 ∫_0 w q sin(kq) dq; sigma is 1/π.
            let expected = -4.0 / k * 0.5 * 1.5 * slope;
            let ours = transform(&smoothing_kernels::CubicSpline, k);
            assert!((ours - expected).abs() < 1e-8, "{k}: {ours} {expected}");
        }
    }
}
