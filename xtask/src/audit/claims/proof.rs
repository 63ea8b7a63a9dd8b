//! Builds the mutated tree and runs the tests and cases that have to catch a mutant.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

use super::mutant::Mutant;
use super::page::Verdict;
use crate::cargo;

/// Quick to build again: little optimised, incremental, without the checks that claims have to do without.
const PROFILE: [&str; 6] = [
    "profile.mutant.inherits=\"dev\"",
    "profile.mutant.debug=false",
    "profile.mutant.debug-assertions=false",
    "profile.mutant.overflow-checks=false",
    "profile.mutant.incremental=true",
    "profile.mutant.codegen-units=64",
];

/// A run may take five times as long as all runs without a mutant, and two minutes more.
const PATIENCE: (f64, f64) = (5.0, 120.0);

/// Exit code of `timeout` for a program that it ended.
const TIMED_OUT: i32 = 124;

/// The tree with its build folder, and the seconds that a run may take.
#[derive(Debug)]
pub(super) struct Proof {
    pub(super) tree: PathBuf,
    target: PathBuf,
    limit: f64,
}

impl Proof {
    /// Runs everything without a mutant, where all has to hold.
    pub(super) fn prepare(tree: PathBuf, target: PathBuf, due: &[Mutant]) -> Result<Self, String> {
        let mut proof = Self { tree, target, limit: f64::from(u32::MAX) };
        let started = Instant::now();
        for is_default_profile in [false, true] {
            let of = || due.iter().filter(|m| m.is_default_profile == is_default_profile);
            let filters: BTreeSet<_> = of().flat_map(|mutant| mutant.filters.clone()).collect();
            let packages: BTreeSet<_> = of().flat_map(|mutant| mutant.packages.clone()).collect();
            let unchanged = Mutant {
                is_structural: true,
                filters: filters.into_iter().collect(),
                packages: packages.into_iter().collect(),
                is_default_profile,
                ..Mutant::default()
            };
            match proof.judge(&unchanged)? {
                Verdict::Survived => {}
                Verdict::Caught(by) => return Err(format!("without a mutant {by} fails")),
                Verdict::Fault(fault) => return Err(format!("without a mutant: {fault}")),
            }
        }
        proof.limit = PATIENCE.0 * started.elapsed().as_secs_f64() + PATIENCE.1;
        Ok(proof)
    }

    /// Builds and runs the tests of a mutant's packages, then its cases, until one catches it.
    pub(super) fn judge(&self, mutant: &Mutant) -> Result<Verdict, String> {
        for package in &mutant.packages {
            let verdict = self.test(package)?;
            if verdict != Verdict::Survived {
                return Ok(verdict);
            }
        }
        if mutant.filters.is_empty() { Ok(Verdict::Survived) } else { self.verify(mutant) }
    }

    fn test(&self, package: &str) -> Result<Verdict, String> {
        let words = ["test", "--package", package];
        if let Some(fault) = self.build(&[&words[..], &["--no-run"]].concat())? {
            return Ok(Verdict::Fault(fault));
        }
        let mut command = self.within_limit("cargo");
        let output = self.of_cargo(&mut command, &words).output();
        let output = output.map_err(|error| format!("cannot start timeout: {error}"))?;
        let said = String::from_utf8_lossy(&output.stdout);
        let failed =
            said.lines().find_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"));
        Ok(match (output.status.code(), failed) {
            (Some(0), _) => Verdict::Survived,
            (Some(TIMED_OUT), _) => self.timed_out(),
            (_, Some(name)) => Verdict::Caught(format!("test `{name}` of {package}")),
            (_, None) => Verdict::Caught(format!("a test of {package}")),
        })
    }

    fn verify(&self, mutant: &Mutant) -> Result<Verdict, String> {
        if let Some(fault) = self.build(&["build", "--package", "verification"])? {
            return Ok(Verdict::Fault(fault));
        }
        let out = self.tree.join("target/verify");
        let report = out.join("report.json");
        // The report of an earlier mutant.
        let _ = std::fs::remove_file(&report);
        let binary = format!("mutant/verification{}", std::env::consts::EXE_SUFFIX);
        let mut command = self.within_limit(self.target.join(binary));
        command.arg("verify").args(&mutant.filters).arg("--out").arg(&out);
        if !mutant.is_default_profile {
            command.arg("--quick");
        }
        command.env("CARGO_MANIFEST_DIR", self.tree.join("tests")).current_dir(&self.tree);
        let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
        let status = status.map_err(|error| format!("cannot start timeout: {error}"))?;
        if status.code() == Some(TIMED_OUT) {
            return Ok(self.timed_out());
        }
        let text = std::fs::read_to_string(&report).unwrap_or_default();
        Ok(match serde_json::from_str(&text) {
            Ok(report) => of_report(&report, mutant.is_structural),
            Err(error) => Verdict::Fault(format!("the proof ended without a report: {error}")),
        })
    }

    /// Builds; returns the first error, if any.
    fn build(&self, words: &[&str]) -> Result<Option<String>, String> {
        let output = self.of_cargo(&mut cargo(), words).output();
        let output = output.map_err(|error| format!("cannot start cargo: {error}"))?;
        let said = String::from_utf8_lossy(&output.stderr);
        let first = said.lines().find(|line| line.starts_with("error")).unwrap_or(&said);
        Ok((!output.status.success()).then(|| format!("does not compile: {first}")))
    }

    fn of_cargo<'a>(&self, command: &'a mut Command, words: &[&str]) -> &'a mut Command {
        for setting in PROFILE {
            command.args(["--config", setting]);
        }
        let options = ["--quiet", "--locked", "--profile", "mutant"];
        command.args(words).args(options).env("CARGO_TARGET_DIR", &self.target);
        command.current_dir(&self.tree)
    }

    fn within_limit(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new("timeout");
        command.arg(format!("{:.0}", self.limit)).arg(program.as_ref());
        command
    }

    fn timed_out(&self) -> Verdict {
        Verdict::Fault(format!("did not end within {:.0} s", self.limit))
    }
}

/// The first failed claim that catches a mutant: one of accuracy, a case that stopped, one of structure if that is what it breaks.
/// A regression bound alone catches nothing.
fn of_report(report: &Value, is_structural: bool) -> Verdict {
    let cases = report["cases"].as_array().into_iter().flatten();
    let claims = cases.flat_map(|case| case["claims"].as_array().into_iter().flatten());
    let mut failed = claims.filter(|claim| claim["passed"] == false).filter(|claim| {
        claim["kind"] == "accuracy"
            || is_structural && claim["kind"] == "structural"
            || claim["id"].as_str().is_some_and(|id| id.ends_with("/ran"))
    });
    failed.next().map_or(Verdict::Survived, |claim| {
        Verdict::Caught(format!("`{}`", claim["id"].as_str().unwrap_or_default()))
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn claims_of_accuracy_and_stopped_cases_catch_and_structural_ones_where_structure_breaks() {
        let verdicts = |id: &str, kind: &str, passed: bool| {
            let claims = json!([{"id": id, "kind": kind, "passed": passed}]);
            let report = json!({"cases": [{"id": "smpm/disks", "claims": claims}]});
            [false, true].map(|is_structural| of_report(&report, is_structural))
        };
        let caught = Verdict::Caught("`a/b`".to_owned());
        assert_eq!(verdicts("a/b", "accuracy", false), [caught.clone(), caught.clone()]);
        assert_eq!(verdicts("a/b", "accuracy", true), [Verdict::Survived, Verdict::Survived]);
        assert_eq!(verdicts("a/b", "structural", false), [Verdict::Survived, caught]);
        assert_eq!(verdicts("a/b", "regression-bound", false)[1], Verdict::Survived);
        assert_eq!(
            verdicts("a/ran", "structural", false)[0],
            Verdict::Caught("`a/ran`".to_owned())
        );
    }
}
