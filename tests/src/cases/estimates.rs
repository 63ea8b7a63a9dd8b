//! Estimates as values and as references of claims.

use result_figures::{Measured, Reference};
use sde_integrators::Estimate;

use crate::case::CaseResult;

/// The value of an estimate with its standard error.
pub(crate) fn sampled(estimate: &Estimate) -> CaseResult<Measured> {
    let standard_error = estimate.standard_error().ok_or("an estimate without standard error")?;
    Ok(Measured::sampled(estimate.value, standard_error))
}

/// An estimate as a reference; without a standard error nothing can be claimed against it.
pub(crate) fn estimated(estimate: &Estimate) -> Reference {
    Reference::uncertain(estimate.value, estimate.standard_error().unwrap_or(f64::NAN))
}
