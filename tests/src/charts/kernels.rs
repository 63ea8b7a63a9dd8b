//! The kernels beside one another, at equal support.

use smoothing_kernels::{Kernel, all};

use crate::case::{CaseError, Context};
use crate::chart::{Line, Scale, TimeSeries, Words};
use crate::charts::{ChartKind, Drawing};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "kernels",
    title: "every smoothing kernel at equal support: value and slope",
    draw,
};

/// Points along a curve.
const POINTS: u32 = 200;

fn draw(_: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let value = |kernel: &dyn Kernel<2>, r: f64, h: f64| kernel.value(r, h);
    let slope = |kernel: &dyn Kernel<2>, r: f64, h: f64| kernel.radial_derivative(r, h);
    Ok(vec![
        picture("kernels-value", "Smoothing kernels in 2-D at equal support", "W(r) R^2", value)?,
        picture(
            "kernels-slope",
            "Slopes of the smoothing kernels in 2-D at equal support",
            "dW/dr R^3",
            slope,
        )?,
    ])
}

fn picture(
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
            let at = |k: u32| f64::from(k) / f64::from(POINTS);
            Line {
                name: name.into(),
                points: (0..=POINTS)
                    .map(|k| (at(k), Some(of(kernel.as_ref(), at(k), h))))
                    .collect(),
            }
        })
        .collect();
    let words = Words {
        title: title.into(),
        subtitle: "R is the support radius; every kernel integrates to one".into(),
        x_label: "r / R".into(),
        y_label: y_label.into(),
        caption: Vec::new(),
    };
    Ok(Drawing::time_series(
        name,
        &TimeSeries { words, scale: Scale::Linear, lines, references: Vec::new() },
    )?)
}
