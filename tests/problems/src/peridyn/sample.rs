//! Means of samples.

use result_figures::Measured;

/// The mean of independent values, with its standard error.
#[must_use]
pub fn mean(values: &[f64]) -> Measured {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    Measured::sampled(mean, (variance / n).sqrt())
}
