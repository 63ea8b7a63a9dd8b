//! What a run of the proof leaves behind: the schema `verification-report/1`.
//!
//! The fields and their order are the schema; they are kept stable.
//! Numbers are finite or `null`: [`result_figures::finite`] refuses the rest.

use std::fmt;

use reference_problems::context::Profile;
use result_figures::{ErrorKind, number};
use scenes::machine::Machine;
use serde::{Deserialize, Serialize};

/// The name of the schema, the first field of every report.
pub const SCHEMA: &str = "verification-report/1";

/// A whole run: every case, what it claimed, and on which machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// Version of the workspace.
    pub version: String,
    /// Commit of the working tree, `-dirty` appended if a tracked file differs; `null` outside git.
    pub commit: Option<String>,
    /// How much was run.
    pub profile: Profile,
    /// Where it was run.
    pub machine: Machine,
    /// The cases, in the order of the table.
    pub cases: Vec<CaseRecord>,
    /// Number of claims that held.
    pub passed: usize,
    /// Number of claims that did not, a case that ended in an error counting as one.
    pub failed: usize,
}

/// One case and its claims.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseRecord {
    /// Begins with the crate, e.g. `fpk-sph/viscous-damper`.
    pub id: String,
    /// One line for the reader.
    pub title: String,
    /// Where the problem and its reference come from.
    pub source: String,
    /// Wall time (s).
    pub seconds: f64,
    /// CPU time of all threads (s); what several cases share counts in the first that asks.
    pub cpu_seconds: f64,
    /// What was claimed.
    pub claims: Vec<Claim>,
    /// What could not be claimed where it ran, and why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub skipped: Vec<String>,
}

/// One number, what it should have been, and the verdict.
///
/// Made by [`Comparison::judged`](crate::claim::Comparison::judged) and its relatives, so that error and verdict always follow from the numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Begins with the id of its case; once given it does not change.
    pub id: String,
    /// What was measured, e.g. `E[q^2]`.
    pub quantity: String,
    /// Its unit; `null` for a pure number.
    pub unit: Option<String>,
    /// With which method, resolution and sample count.
    pub method: String,
    /// The value found; `null` if it was not a finite number (the claim has then failed).
    pub measured: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// The value expected.
    pub reference: Option<f64>,
    /// The error of the expected value, one sigma or a bound.
    pub reference_error: Option<f64>,
    /// Signed, in the measure named by `error_kind`.
    pub error: Option<f64>,
    /// How `error` was formed.
    pub error_kind: ErrorKind,
    /// The largest error that passes.
    pub tolerance: Option<f64>,
    /// Why that tolerance.
    pub reason: String,
    /// The verdict.
    pub passed: bool,
    /// What kind of statement it is.
    pub kind: ClaimKind,
}

/// What kind of statement a claim is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimKind {
    /// An error against a reference: within a tolerance, or a bias bound and standard errors.
    Accuracy,
    /// Bitwise equality, a count, a typed error or another yes or no: a property without a reference value.
    Structural,
    /// A value or an error held to where it was measured: no statement of accuracy.
    RegressionBound,
}

impl ClaimKind {
    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Accuracy => "accuracy",
            Self::Structural => "structural",
            Self::RegressionBound => "regression bound",
        }
    }
}

/// The claims that hold, by kind, those that do not, and those whose tolerance is loose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Claims of accuracy that hold.
    pub accuracy: usize,
    /// Structural claims that hold.
    pub structural: usize,
    /// Regression bounds that hold.
    pub regression_bounds: usize,
    /// Claims of any kind that do not hold.
    pub failed: usize,
    /// Claims with a tolerance over ten times the error and no reason for it: [`Claim::is_loose`].
    pub loose: usize,
}

impl Counts {
    /// Counts these claims.
    #[must_use]
    pub fn of<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Self {
        let mut counts = Self::default();
        for claim in claims {
            counts.loose += usize::from(claim.is_loose());
            let count = match claim.kind {
                _ if !claim.passed => &mut counts.failed,
                ClaimKind::Accuracy => &mut counts.accuracy,
                ClaimKind::Structural => &mut counts.structural,
                ClaimKind::RegressionBound => &mut counts.regression_bounds,
            };
            *count += 1;
        }
        counts
    }

    /// All claims.
    #[must_use]
    pub const fn all(&self) -> usize {
        self.accuracy + self.structural + self.regression_bounds + self.failed
    }
}

impl fmt::Display for Counts {
    /// `N of accuracy, M structural, K regression bounds; F failed`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { accuracy, structural, regression_bounds, failed, .. } = self;
        let bounds = number::counted(*regression_bounds, "regression bound");
        write!(f, "{accuracy} of accuracy, {structural} structural, {bounds}; {failed} failed")
    }
}

impl Report {
    /// Gathers the cases and counts their claims.
    #[must_use]
    pub fn new(profile: Profile, machine: Machine, cases: Vec<CaseRecord>) -> Self {
        let passed =
            cases.iter().flat_map(|case| &case.claims).filter(|claim| claim.passed).count();
        let total: usize = cases.iter().map(|case| case.claims.len()).sum();
        Self {
            schema: SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: scenes::machine::commit(),
            profile,
            machine,
            cases,
            passed,
            failed: total - passed,
        }
    }

    /// All claims, case by case.
    pub fn claims(&self) -> impl Iterator<Item = &Claim> {
        self.cases.iter().flat_map(|case| &case.claims)
    }

    /// How many claims of each kind hold, how many do not, and how many are loose.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts::of(self.claims())
    }

    /// The claims that did not hold.
    pub fn failures(&self) -> impl Iterator<Item = &Claim> {
        self.cases.iter().flat_map(|case| &case.claims).filter(|claim| !claim.passed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claim::Subject;

    fn sample() -> Report {
        let claim = Subject::new("self-check/pi/value", "pi", "22/7")
            .unit("rad")
            .relative(22.0 / 7.0, std::f64::consts::PI)
            .within(1e-3)
            .because("the error of 22/7 is 4.0e-4");
        let case = CaseRecord {
            id: "self-check/pi".into(),
            title: "an approximation".into(),
            source: "Archimedes".into(),
            seconds: 0.25,
            cpu_seconds: 0.5,
            claims: vec![claim],
            skipped: Vec::new(),
        };
        Report::new(Profile::Quick, Machine::read(), vec![case])
    }

    #[test]
    fn the_keys_of_the_schema_are_the_agreed_ones_in_their_order() {
        let text = result_figures::finite::to_json(&sample()).unwrap();
        let keys = [
            "schema",
            "version",
            "commit",
            "profile",
            "machine",
            "cases",
            "id",
            "title",
            "source",
            "seconds",
            "cpu_seconds",
            "claims",
            "id",
            "quantity",
            "unit",
            "method",
            "measured",
            "standard_error",
            "reference",
            "reference_error",
            "error",
            "error_kind",
            "tolerance",
            "reason",
            "passed",
            "kind",
            "passed",
            "failed",
        ];
        let mut rest = text.as_str();
        for key in keys {
            let at = rest
                .find(&format!("\"{key}\":"))
                .unwrap_or_else(|| panic!("{key} missing or out of order"));
            rest = &rest[at + 1..];
        }
        assert!(text.contains("\"standard_error\": null"), "{text}");
        assert!(text.contains("\"profile\": \"quick\""), "{text}");
        assert!(text.contains("\"kind\": \"accuracy\""), "{text}");
    }

    #[test]
    fn kinds_are_counted_apart_and_a_failed_claim_for_none() {
        let mut claims = sample().cases.swap_remove(0).claims;
        claims.push(Claim { passed: false, ..claims[0].clone() });
        claims.push(claims[0].clone().structural());
        let counts = Counts::of(&claims);
        assert_eq!(
            counts.to_string(),
            "1 of accuracy, 1 structural, 0 regression bounds; 1 failed"
        );
        assert_eq!(counts.all(), 3);
    }

    #[test]
    fn a_report_survives_writing_and_reading() {
        let report = sample();
        let text = result_figures::finite::to_json(&report).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
        assert_eq!((report.passed, report.failed), (1, 0));
    }
}
