//! A number with its error, as a result file has it.

use sde_integrators::Estimate;
use serde::Serialize;

use crate::run_result::{ErrorOrigin, error_of};

/// A number with its error.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) error: Option<f64>,
    error_kind: ErrorOrigin,
}

impl From<Estimate> for Number {
    fn from(estimate: Estimate) -> Self {
        let (error, error_kind) = error_of(&estimate);
        Self { value: estimate.value, error, error_kind }
    }
}
