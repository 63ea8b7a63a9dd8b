//! Errors for data that cannot be drawn.

/// Data that cannot be drawn.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum ChartError {
    /// A value is NaN or infinite.
    #[error("series `{series}`: the {quantity} is {value}, not a finite number")]
    NotFinite {
        /// Name of the series.
        series: String,
        /// Name of the quantity.
        quantity: &'static str,
        /// The value.
        value: f64,
    },
    /// A value on a logarithmic axis is zero or negative.
    #[error("series `{series}`: the {quantity} {value} cannot be drawn on a logarithmic axis")]
    NotPositive {
        /// Name of the series.
        series: String,
        /// Name of the quantity.
        quantity: &'static str,
        /// The value.
        value: f64,
    },
    /// The chart has no point.
    #[error("the chart `{title}` has no point to draw")]
    Empty {
        /// Title of the chart.
        title: String,
    },
    /// The drawing library failed.
    #[error("the picture could not be drawn: {message}")]
    Picture {
        /// Error text of the drawing library.
        message: String,
    },
}

pub(crate) fn check_finite(
    series: &str,
    quantity: &'static str,
    value: f64,
) -> Result<f64, ChartError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ChartError::NotFinite { series: series.into(), quantity, value })
    }
}

pub(crate) fn check_positive(
    series: &str,
    quantity: &'static str,
    value: f64,
) -> Result<f64, ChartError> {
    let value = check_finite(series, quantity, value)?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err(ChartError::NotPositive { series: series.into(), quantity, value })
    }
}
