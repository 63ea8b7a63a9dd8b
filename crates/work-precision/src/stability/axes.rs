//! Axes and labels common to all maps.

use result_figures::Words;

/// `n` equally spaced values.
pub(super) fn linear(n: u32, from: f64, to: f64) -> Vec<f64> {
    (0..n).map(|k| from + (to - from) * f64::from(k) / f64::from(n - 1)).collect()
}

/// `n` logarithmically spaced values.
pub(super) fn logarithmic(n: u32, from: f64, to: f64) -> Vec<f64> {
    linear(n, from.ln(), to.ln()).into_iter().map(f64::exp).collect()
}

/// Title and labels of a map with a one-line caption.
pub(super) fn words(
    title: String,
    subtitle: &str,
    [x_label, y_label]: [&str; 2],
    caption: &str,
) -> Words {
    Words {
        title,
        subtitle: subtitle.into(),
        x_label: x_label.into(),
        y_label: y_label.into(),
        caption: vec![caption.into()],
    }
}
