//! A value of a run with its error.

use serde::Serialize;

use crate::run_result::ErrorOrigin;

/// A quantity at a time, with its error.
#[derive(Debug, Serialize)]
pub(super) struct Observed {
    pub(super) t: f64,
    pub(super) value: f64,
    pub(super) error: Option<f64>,
    pub(super) error_kind: ErrorOrigin,
    /// What the value rests on, where that is not firm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) note: Option<String>,
}

impl Observed {
    /// The value, unless its error leaves nothing of it.
    pub(super) fn known(&self) -> Option<f64> {
        self.error.is_none_or(|error| error < self.value.abs()).then_some(self.value)
    }
}
