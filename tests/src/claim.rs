//! From a measured value and its reference to a verdict.
//!
//! A claim reads as a sentence: `lines.of(name, quantity).relative(value, reference).within(tolerance).because(reason)`.
//! The error is formed by its [`ErrorKind`], the verdict by a [`Criterion`]; neither is ever stated by hand.
//! A NaN fails, as does a claim without a reason or one that its own uncertainty would make empty.

#[cfg(test)]
mod tests;

use result_figures::{ErrorKind, Measured, Reference, Spread};

use crate::report::{Claim, ClaimKind};

/// Begins the reason of a regression bound.
const REGRESSION_BOUND: &str = "as measured, ";
/// Begins the reason of a Monte Carlo claim; a colon ends it.
const BIAS_BOUND: &str = "bias bound ";

/// A reason begins so where the error seen is no measure of what the error may be: roundoff, whose bound counts operations; a
/// sample whose error happened to be small; a chaotic quantity.
const NOT_BY_ERROR: [&str; 3] = ["roundoff: ", "statistics: ", "chaos: "];
/// A tolerance over so many times the error seen is loose.
const LOOSE: f64 = 10.0;

/// A Monte Carlo claim passes within this many standard errors of its bias bound.
pub const STANDARD_ERRORS: f64 = 4.0;

/// What a claim is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Subject {
    /// Full id, e.g. `fpk-sph/viscous-damper/log-density-fit/second-moment-q/t6`.
    pub id: String,
    /// What was measured, e.g. `E[q^2]`.
    pub quantity: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// With which method, resolution and sample count.
    pub method: String,
}

impl Subject {
    /// Names what is claimed, a pure number. In a case, [`Context::subject`](crate::case::Context::subject) adds the case's id.
    #[must_use]
    pub fn new(
        id: impl Into<String>,
        quantity: impl Into<String>,
        method: impl Into<String>,
    ) -> Self {
        let (id, quantity, method) = (id.into(), quantity.into(), method.into());
        Self { id, quantity, unit: String::new(), method }
    }

    /// The same with a unit.
    #[must_use]
    pub fn unit(self, unit: impl Into<String>) -> Self {
        Self { unit: unit.into(), ..self }
    }

    /// A value and its reference, compared by a kind of error.
    #[must_use]
    pub fn compared(
        self,
        kind: ErrorKind,
        measured: impl Into<Measured>,
        reference: impl Into<Reference>,
    ) -> Comparison {
        Comparison { subject: self, kind, measured: measured.into(), reference: reference.into() }
    }

    /// A value and its reference: their relative distance.
    #[must_use]
    pub fn relative(
        self,
        measured: impl Into<Measured>,
        reference: impl Into<Reference>,
    ) -> Comparison {
        self.compared(ErrorKind::Relative, measured, reference)
    }

    /// A value and its reference: their difference.
    #[must_use]
    pub fn absolute(
        self,
        measured: impl Into<Measured>,
        reference: impl Into<Reference>,
    ) -> Comparison {
        self.compared(ErrorKind::Absolute, measured, reference)
    }

    /// A probability and its reference: the difference of their decimal logarithms.
    #[must_use]
    pub fn log10(
        self,
        measured: impl Into<Measured>,
        reference: impl Into<Reference>,
    ) -> Comparison {
        self.compared(ErrorKind::Log10, measured, reference)
    }

    /// A fitted order with its standard error, and the expected order.
    #[must_use]
    pub fn order(self, fitted: Measured, expected: f64) -> Comparison {
        self.compared(ErrorKind::Order, fitted, expected)
    }

    /// An error, which should be zero: passes if its size is within the tolerance.
    #[must_use]
    pub fn bounded(self, error: f64, tolerance: f64) -> Pending<impl FnOnce(&str) -> Claim> {
        self.absolute(error, 0.0).within(tolerance)
    }

    /// A value without a reference, held to the range in which it was measured: a regression bound.
    #[must_use]
    pub fn measured(
        self,
        value: impl Into<Measured>,
        (from, to): (f64, f64),
    ) -> Pending<impl FnOnce(&str) -> Claim> {
        let measured = value.into();
        Pending(move |reason: &str| self.in_range(measured, (from, to), reason))
    }

    fn in_range(self, measured: Measured, (from, to): (f64, f64), reason: &str) -> Claim {
        let outside = !(from <= measured.value && measured.value <= to);
        let objection = unusable(measured, None)
            .or_else(|| no_reason(reason))
            .or_else(|| outside.then(|| format!("measured {} is outside", measured.value)));
        let reason = format!("{REGRESSION_BOUND}value in [{from}, {to}]: {reason}");
        Claim {
            measured: finite(measured.value),
            standard_error: measured.standard_error.and_then(finite),
            passed: objection.is_none(),
            kind: ClaimKind::RegressionBound,
            reason: with_objection(reason, objection),
            ..self.without_numbers()
        }
    }

    /// Two results that must be bitwise identical: `n_different` values out of `n_compared` differ.
    #[must_use]
    pub fn same_bits(
        self,
        n_different: usize,
        n_compared: usize,
    ) -> Pending<impl FnOnce(&str) -> Claim> {
        Pending(move |reason: &str| {
            let mut claim = self.bounded(n_different as f64, 0.0).because(reason).structural();
            claim.reason = format!("{} ({n_compared} values compared)", claim.reason);
            claim.passed &= n_compared > 0;
            claim
        })
    }

    /// A claim that fails, without numbers.
    fn without_numbers(self) -> Claim {
        Claim {
            id: self.id,
            quantity: self.quantity,
            unit: Some(self.unit).filter(|unit| !unit.is_empty()),
            method: self.method,
            measured: None,
            standard_error: None,
            reference: None,
            reference_error: None,
            error: None,
            error_kind: ErrorKind::Absolute,
            tolerance: None,
            reason: String::new(),
            passed: false,
            kind: ClaimKind::Structural,
        }
    }
}

/// A claim that lacks its reason.
#[derive(Debug, Clone)]
pub struct Pending<F>(F);

impl<F: FnOnce(&str) -> Claim> Pending<F> {
    /// The claim with the reason for its tolerance: truncation, roundoff, or what was measured.
    #[must_use]
    pub fn because(self, reason: &str) -> Claim {
        (self.0)(reason)
    }
}

/// A value beside its reference; a criterion makes it a [`Claim`].
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    subject: Subject,
    kind: ErrorKind,
    measured: Measured,
    reference: Reference,
}

impl Comparison {
    /// [`Criterion::Within`] a tolerance.
    #[must_use]
    pub fn within(self, tolerance: f64) -> Pending<impl FnOnce(&str) -> Claim> {
        Pending(move |reason: &str| self.judged(Criterion::Within { tolerance, reason }))
    }

    /// [`Criterion::MonteCarlo`] with a bias bound.
    #[must_use]
    pub fn monte_carlo(self, bias_bound: f64) -> Pending<impl FnOnce(&str) -> Claim> {
        Pending(move |reason: &str| self.judged(Criterion::MonteCarlo { bias_bound, reason }))
    }

    /// [`Criterion::AsMeasured`]: a regression bound of the error.
    #[must_use]
    pub fn as_measured(self, from: f64, to: f64) -> Pending<impl FnOnce(&str) -> Claim> {
        Pending(move |reason: &str| self.judged(Criterion::AsMeasured { from, to, reason }))
    }

    /// Forms the error and decides whether it passes.
    #[must_use]
    pub fn judged(self, criterion: Criterion<'_>) -> Claim {
        let Self { subject, kind, measured, reference } = self;
        let error = kind.error(measured.value, reference.value);
        let spread = kind.spread(measured, reference);
        let verdict = criterion.decide(kind, error, spread, measured.standard_error.is_some());
        let unusable = unusable(measured, Some(reference));
        Claim {
            measured: finite(measured.value),
            standard_error: measured.standard_error.and_then(finite),
            reference: finite(reference.value),
            reference_error: reference.error.and_then(finite),
            error: finite(error),
            error_kind: kind,
            tolerance: finite(verdict.tolerance),
            passed: verdict.objection.is_none() && unusable.is_none(),
            kind: criterion.kind(kind, measured, reference),
            reason: with_objection(verdict.reason, unusable.or(verdict.objection)),
            ..subject.without_numbers()
        }
    }
}

/// When a claim passes, and why there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Criterion<'a> {
    /// |error| <= tolerance. The reference must be known better than that.
    Within {
        /// In the measure of the error kind (a factor >= 1 for [`ErrorKind::Ratio`]).
        tolerance: f64,
        /// Truncation, roundoff, or what was seen.
        reason: &'a str,
    },
    /// |error| <= bias bound + 4 standard errors of measured value and reference together.
    MonteCarlo {
        /// In the measure of the error kind (excess over 1 for [`ErrorKind::Ratio`]).
        bias_bound: f64,
        /// Where the bias bound comes from.
        reason: &'a str,
    },
    /// The signed error lies where it was measured: a regression bound, no statement of accuracy.
    AsMeasured {
        /// Smallest error that passes.
        from: f64,
        /// Largest error that passes.
        to: f64,
        /// Why the error is what it is.
        reason: &'a str,
    },
}

impl Claim {
    /// The same claim, counted as one of structure: a property without a reference value, e.g. an invariant or a typed error.
    ///
    /// Equal bits and counts (an absolute tolerance of zero about an exact whole number) are structural without it.
    #[must_use]
    pub fn structural(mut self) -> Self {
        self.kind = ClaimKind::Structural;
        self
    }

    /// Whether it is a regression bound: it says how wrong a method is.
    #[must_use]
    pub fn is_regression_bound(&self) -> bool {
        self.kind == ClaimKind::RegressionBound
    }

    /// Whether its tolerance is over ten times the error seen and its reason does not begin with `roundoff: `, `statistics: `
    /// or `chaos: `. A claim with a standard error is judged by that, and is not loose.
    #[must_use]
    pub fn is_loose(&self) -> bool {
        let is_within = !self.is_regression_bound()
            && self.standard_error.is_none()
            && !self.reason.starts_with(BIAS_BOUND);
        let is_by_error = !NOT_BY_ERROR.iter().any(|prefix| self.reason.starts_with(prefix));
        let (Some(error), Some(tolerance)) = (self.error, self.tolerance) else { return false };
        let one = if self.error_kind == ErrorKind::Ratio { 1.0 } else { 0.0 };
        is_within && is_by_error && tolerance - one > LOOSE * (error.abs() - one)
    }

    /// Whether it says that an aim was missed: a regression bound, or a tolerance wider than what was wanted.
    #[must_use]
    pub fn falls_short(&self) -> bool {
        self.is_regression_bound() || self.reason.contains("not reached")
    }

    /// The reason as the case gives it, without the numbers of a Monte Carlo claim before it.
    #[must_use]
    pub fn grounds(&self) -> &str {
        let numbers = self.reason.strip_prefix(BIAS_BOUND).and_then(|rest| rest.split_once(": "));
        numbers.map_or(&self.reason, |(_, grounds)| grounds)
    }

    /// The part of the tolerance that the error takes; none without an error and a tolerance.
    #[must_use]
    pub fn used(&self) -> Option<f64> {
        let (error, tolerance) = (self.error?.abs(), self.tolerance?);
        let one = if self.error_kind == ErrorKind::Ratio { 1.0 } else { 0.0 };
        // No error is none of a tolerance of zero.
        if error <= one { Some(0.0) } else { Some((error - one) / (tolerance - one)) }
    }

    /// The row of a case that ended in an error.
    #[must_use]
    pub fn case_error(case_id: &str, message: &str) -> Self {
        let subject = Subject::new(format!("{case_id}/ran"), "the case ran to its end", "");
        Self { reason: format!("error: {message}"), ..subject.without_numbers() }
    }
}

struct Verdict {
    tolerance: f64,
    reason: String,
    objection: Option<String>,
}

impl Criterion<'_> {
    /// A count is structural by itself: an absolute tolerance of zero about a whole number that is known exactly.
    fn kind(self, kind: ErrorKind, measured: Measured, reference: Reference) -> ClaimKind {
        let is_count = kind == ErrorKind::Absolute
            && measured.standard_error.is_none()
            && reference.error.is_none()
            && reference.value.fract() == 0.0;
        match self {
            Self::AsMeasured { .. } => ClaimKind::RegressionBound,
            Self::Within { tolerance: 0.0, .. } if is_count => ClaimKind::Structural,
            Self::Within { .. } | Self::MonteCarlo { .. } => ClaimKind::Accuracy,
        }
    }

    fn decide(
        self,
        kind: ErrorKind,
        error: f64,
        spread: Spread,
        has_standard_error: bool,
    ) -> Verdict {
        match self {
            Self::Within { tolerance, reason } => {
                let slack = if kind == ErrorKind::Ratio { tolerance - 1.0 } else { tolerance };
                let objection = no_reason(reason)
                    .or_else(|| too_uncertain("reference", spread.of_reference, slack))
                    .or_else(|| {
                        order_without_error(kind, spread.of_measured, slack, has_standard_error)
                    })
                    .or_else(|| beyond(error, tolerance));
                Verdict { tolerance, reason: reason.into(), objection }
            }
            Self::MonteCarlo { bias_bound, reason } => {
                let unit = if kind == ErrorKind::Ratio { 1.0 } else { 0.0 };
                let spread = spread.of_measured.hypot(spread.of_reference);
                let tolerance = unit + bias_bound + STANDARD_ERRORS * spread;
                let missing = (!has_standard_error)
                    .then(|| "a Monte Carlo value without its standard error".into());
                let objection = no_reason(reason).or(missing).or_else(|| beyond(error, tolerance));
                let reason = format!(
                    "{BIAS_BOUND}{bias_bound} + {STANDARD_ERRORS} s.e. of {spread:.2e}: {reason}"
                );
                Verdict { tolerance, reason, objection }
            }
            Self::AsMeasured { from, to, reason } => {
                let outside = !(from <= error && error <= to);
                let objection = no_reason(reason)
                    .or_else(|| outside.then(|| format!("the error {error:.3e} is outside")));
                let reason = format!("{REGRESSION_BOUND}error in [{from}, {to}]: {reason}");
                Verdict { tolerance: from.abs().max(to.abs()), reason, objection }
            }
        }
    }
}

fn beyond(error: f64, tolerance: f64) -> Option<String> {
    if error.is_nan() {
        return Some("the error is not a number".into());
    }
    let holds = error.abs() <= tolerance;
    (!holds).then(|| format!("the error {error:.3e} exceeds the tolerance {tolerance:.3e}"))
}

/// A reference known no better than the tolerance proves nothing.
fn too_uncertain(what: &str, sigma: f64, tolerance: f64) -> Option<String> {
    (sigma > tolerance).then(|| {
        format!("the error {sigma:.2e} of the {what} exceeds the tolerance {tolerance:.2e}")
    })
}

fn order_without_error(
    kind: ErrorKind,
    sigma: f64,
    tolerance: f64,
    has_standard_error: bool,
) -> Option<String> {
    if kind != ErrorKind::Order {
        return None;
    }
    let missing = (!has_standard_error).then(|| "an order without its standard error".to_owned());
    missing.or_else(|| too_uncertain("fitted order", sigma, tolerance))
}

fn no_reason(reason: &str) -> Option<String> {
    reason.trim().is_empty().then(|| "no reason is given for the tolerance".to_owned())
}

/// Why these numbers cannot be judged, if they cannot.
fn unusable(measured: Measured, reference: Option<Reference>) -> Option<String> {
    let bad = |value: f64| !value.is_finite();
    let bad_error = |error: Option<f64>| error.is_some_and(|error| bad(error) || error < 0.0);
    if bad(measured.value) {
        return Some(format!("measured {}", measured.value));
    }
    if bad_error(measured.standard_error) {
        return Some(format!("standard error {:?}", measured.standard_error));
    }
    let reference = reference?;
    if bad(reference.value) || bad_error(reference.error) {
        return Some(format!("reference {} with error {:?}", reference.value, reference.error));
    }
    None
}

/// `null` in the report is meant: the claim has failed and its reason says what was there.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn with_objection(reason: String, objection: Option<String>) -> String {
    match objection {
        Some(objection) => format!("{reason} [failed: {objection}]"),
        None => reason,
    }
}
