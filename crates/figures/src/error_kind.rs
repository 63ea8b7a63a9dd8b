//! How the distance of a measured value from its reference is taken.

use serde::{Deserialize, Serialize};

use crate::measured::{Measured, Reference};

/// How the distance between a measured value m and its reference r is taken.
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
    /// m - r of two orders of convergence; m must carry its standard error.
    Order,
}

impl ErrorKind {
    /// The word used in the report.
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
}

impl ErrorKind {
    /// The distance of m from r in this measure; NaN where it has none.
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

    /// One sigma of that distance, to first order in the errors of m and r.
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

/// One sigma of an error, by where it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// From the measured value.
    pub of_measured: f64,
    /// From the reference.
    pub of_reference: f64,
}
