//! Claims of one run of any dimension.

use crate::case::{CaseError, Context};
use crate::claim::{Criterion, Measured, Reference};
use crate::fpk::density::{DensityRun, Row};
use crate::fpk::scene::FpkScene;
use crate::report::{Claim, ErrorKind};
use crate::scene::SceneFile;

/// One run: the front of its ids, and its method.
pub(super) struct Lines<'a> {
    pub(super) context: &'a Context<'a>,
    pub(super) id: &'a str,
    pub(super) method: String,
}

impl Lines<'_> {
    /// A value against its reference.
    pub(super) fn judge(
        &self,
        (name, quantity, unit): (&str, &str, &str),
        kind: ErrorKind,
        value: f64,
        reference: Reference,
        criterion: Criterion<'_>,
    ) -> Claim {
        let name = format!("{}/{name}", self.id);
        let subject = self.context.subject(&name, quantity, unit, &self.method);
        Claim::judge(subject, kind, Measured::exact(value), reference, criterion)
    }

    /// A value without a reference, where it was seen.
    pub(super) fn measured(
        &self,
        (name, quantity, unit): (&str, &str, &str),
        value: f64,
        (from, to): (f64, f64),
        reason: &str,
    ) -> Claim {
        let name = format!("{}/{name}", self.id);
        let subject = self.context.subject(&name, quantity, unit, &self.method);
        Claim::as_measured(subject, Measured::exact(value), from, to, reason)
    }
}

/// A scene by its file.
pub(super) fn scene(name: &str, text: &str) -> Result<FpkScene, CaseError> {
    Ok(SceneFile::from_text(name, text.to_owned())?.parse()?)
}

/// The row of a time, or why there is none.
pub(super) fn row(run: &DensityRun, t: f64) -> Result<&Row, CaseError> {
    run.at(t).ok_or_else(|| format!("no row at t = {t}: {:?}", run.stopped).into())
}
