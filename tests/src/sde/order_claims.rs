//! Claims on orders of convergence.

use result_figures::{ErrorKind, Measured, Reference};
use work_precision::problems::sde::orders::{Errors, Level};

use crate::case::Context;
use crate::claim::Criterion;
use crate::report::Claim;

/// How closely an order must be met.
#[derive(Debug, Clone, Copy)]
pub struct Tolerance {
    /// On the slope.
    pub slope: f64,
    /// Where no slope can be fitted: on the error at the finest level, besides 4 standard errors.
    pub accuracy: f64,
    /// Why.
    pub reason: &'static str,
}

/// The claim on an order: a fitted slope, or the accuracy where the errors are below their noise.
#[must_use]
pub fn claim(
    context: &Context<'_>,
    (id, what, method): (&str, &str, &str),
    errors: &Errors,
    expected: f64,
    tolerance: Tolerance,
) -> Claim {
    let words = |level: &Level| {
        let Measured { value, standard_error } = level.error;
        format!(
            "{:.3e} (s.e. {:.0e}) at h = {:.3e}",
            value,
            standard_error.unwrap_or(0.0),
            level.dt
        )
    };
    let ends = match (errors.levels.first(), errors.levels.last()) {
        (Some(first), Some(last)) => format!("{method}: {} to {}", words(first), words(last)),
        _ => method.to_owned(),
    };
    if let Some(order) = errors.order {
        let subject = context.subject(id, what, "", &ends);
        let criterion = Criterion::Within { tolerance: tolerance.slope, reason: tolerance.reason };
        return Claim::judge(
            subject,
            ErrorKind::Order,
            order,
            Reference::exact(expected),
            criterion,
        );
    }
    let finest = errors.levels.last().map_or(Measured::exact(f64::NAN), |level| level.error);
    let subject = context.subject(id, &format!("error, for {what}"), "", &ends);
    let reason =
        "fewer than four levels of one sign are above their noise: accuracy instead of a slope";
    let criterion = Criterion::MonteCarlo { bias_bound: tolerance.accuracy, reason };
    Claim::judge(subject, ErrorKind::Absolute, finest, Reference::exact(0.0), criterion)
}
