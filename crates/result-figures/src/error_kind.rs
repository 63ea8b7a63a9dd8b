//! Measures of the difference between a measured value and its reference.

use serde::{Deserialize, Serialize};

use crate::measured::{Measured, Reference};

/// Measure of the difference between a measured value m and its reference r.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorKind {
    /// (m - r) / |r|
    Relative,
    /// m - r
    Absolute,
    /// log10(m / r), for probabilities.
    Log10,
    /// The factor max(m / r, r / m), at least 1, for costs.
    Ratio,
    /// m - r of two orders of convergence; m must have a standard error.
    Order,
}

impl ErrorKind {
    /// Name used in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Relative => "relative",
            Self::Absolute => "absolute",
            Self::Log10 => "log10",
            Self::Ratio => "ratio",
            Self::Order => "order",
        }
    }

    /// The difference between m and r in this measure; NaN where undefined.
    #[must_use]
    pub fn error(self, m: f64, r: f64) -> f64 {
        match self {
            Self::Relative if r == 0.0 => f64::NAN,
            Self::Relative => (m - r) / r.abs(),
            Self::Absolute | Self::Order => m - r,
            Self::Log10 if m > 0.0 && r > 0.0 => (m / r).log10(),
            Self::Ratio if m > 0.0 && r > 0.0 => (m / r).max(r / m),
            Self::Log10 | Self::Ratio => f64::NAN,
        }
    }

    /// Standard deviation of that difference, to first order in the errors of m and r.
    #[must_use]
    pub fn spread(self, measured: Measured, reference: Reference) -> Spread {
        let (m, r) = (measured.value, reference.value);
        let (of_m, of_r) = (measured.standard_error.unwrap_or(0.0), reference.error.unwrap_or(0.0));
        let (from_m, from_r) = match self {
            Self::Relative => (of_m / r.abs(), of_r * m.abs() / (r * r)),
            Self::Absolute | Self::Order => (of_m, of_r),
            Self::Log10 => (of_m / m / std::f64::consts::LN_10, of_r / r / std::f64::consts::LN_10),
            Self::Ratio => (of_m / m * self.error(m, r), of_r / r * self.error(m, r)),
        };
        Spread { of_measured: from_m, of_reference: from_r }
    }
}

/// Standard deviation of an error, by source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Contribution of the measured value.
    pub of_measured: f64,
    /// Contribution of the reference.
    pub of_reference: f64,
}
