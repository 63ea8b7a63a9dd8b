//! Claims of one run of any dimension.

use result_figures::{ErrorKind, Measured, Reference};

use crate::case::Context;
use crate::claim::{Criterion, Subject};
use crate::report::Claim;

/// One run: the front of its ids, empty for none, and its method.
pub(super) struct Lines<'a> {
    pub(super) context: &'a Context<'a>,
    pub(super) id: &'a str,
    pub(super) method: String,
}

impl Lines<'_> {
    fn subject(&self, (name, quantity, unit): (&str, &str, &str)) -> Subject {
        let front = if self.id.is_empty() { String::new() } else { format!("{}/", self.id) };
        self.context.subject(&format!("{front}{name}"), quantity, unit, &self.method)
    }

    /// A value against its reference.
    pub(super) fn judge(
        &self,
        of: (&str, &str, &str),
        kind: ErrorKind,
        value: f64,
        reference: Reference,
        criterion: Criterion<'_>,
    ) -> Claim {
        self.judge_measured(of, kind, Measured::exact(value), reference, criterion)
    }

    /// A value with its standard error against its reference.
    pub(super) fn judge_measured(
        &self,
        of: (&str, &str, &str),
        kind: ErrorKind,
        value: Measured,
        reference: Reference,
        criterion: Criterion<'_>,
    ) -> Claim {
        Claim::judge(self.subject(of), kind, value, reference, criterion)
    }

    /// A value against one that is known exactly: their relative distance.
    pub(super) fn relative(
        &self,
        of: (&str, &str, &str),
        value: f64,
        exact: f64,
        tolerance: f64,
        reason: &str,
    ) -> Claim {
        let criterion = Criterion::Within { tolerance, reason };
        self.judge(of, ErrorKind::Relative, value, Reference::exact(exact), criterion)
    }

    /// What would be zero without error.
    pub(super) fn bounded(
        &self,
        of: (&str, &str, &str),
        value: f64,
        tolerance: f64,
        reason: &str,
    ) -> Claim {
        let criterion = Criterion::Within { tolerance, reason };
        self.judge(of, ErrorKind::Absolute, value, Reference::exact(0.0), criterion)
    }

    /// A value without a reference, where it was seen.
    pub(super) fn measured(
        &self,
        of: (&str, &str, &str),
        value: f64,
        range: (f64, f64),
        reason: &str,
    ) -> Claim {
        self.sampled(of, Measured::exact(value), range, reason)
    }

    /// A value with its standard error, where it was seen.
    pub(super) fn sampled(
        &self,
        of: (&str, &str, &str),
        value: Measured,
        (from, to): (f64, f64),
        reason: &str,
    ) -> Claim {
        Claim::as_measured(self.subject(of), value, from, to, reason)
    }
}
