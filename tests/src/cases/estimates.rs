//! Claims of estimates with a standard error.

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::Estimate;

use crate::case::{CaseError, Context};
use crate::claim::Criterion;
use crate::report::Claim;

/// The value of an estimate with its standard error.
pub(crate) fn sampled(estimate: &Estimate) -> Result<Measured, CaseError> {
    let standard_error = estimate.standard_error().ok_or("an estimate without standard error")?;
    Ok(Measured::sampled(estimate.value, standard_error))
}

/// A Monte Carlo claim against an exact value, relative.
pub(crate) fn against_exact(
    context: &Context<'_>,
    (name, quantity, method): (&str, &str, &str),
    estimate: &Estimate,
    exact: f64,
    (bias_bound, reason): (f64, &str),
) -> Result<Claim, CaseError> {
    Ok(Claim::judge(
        context.subject(name, quantity, "", method),
        ErrorKind::Relative,
        sampled(estimate)?,
        Reference::exact(exact),
        Criterion::MonteCarlo { bias_bound, reason },
    ))
}
