//! Builds the copy and runs the cases of its mutants.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::mutant::Mutant;
use super::outcome::Outcome;
use crate::cargo;

/// Quick to build again: little optimised, kept from build to build, and without the checks that claims have to do without.
const PROFILE: [&str; 6] = [
    "profile.mutant.inherits=\"dev\"",
    "profile.mutant.debug=false",
    "profile.mutant.debug-assertions=false",
    "profile.mutant.overflow-checks=false",
    "profile.mutant.incremental=true",
    "profile.mutant.codegen-units=64",
];

/// A run may take as many times what it took without a mutant, and these seconds more.
const PATIENCE: (f64, f64) = (5.0, 120.0);

/// The copy of the tree and where it is built.
#[derive(Debug)]
pub(super) struct Proof {
    pub(super) tree: PathBuf,
    pub(super) target: PathBuf,
}

/// How a run ended.
enum Run {
    Report(Value),
    Fault(String),
}

impl Proof {
    /// Builds; the first error otherwise.
    pub(super) fn build(&self) -> Result<(), String> {
        let mut command = cargo();
        for setting in PROFILE {
            command.args(["--config", setting]);
        }
        command
            .args(["build", "--quiet", "--locked", "--profile", "mutant"])
            .args(["--package", "verification", "--bin", "verification"])
            .current_dir(&self.tree)
            .env("CARGO_TARGET_DIR", &self.target)
            .stdout(Stdio::null());
        let output = command.output().map_err(|error| format!("cannot start cargo: {error}"))?;
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let first = said.lines().find(|line| line.starts_with("error")).unwrap_or(&said);
        Err(first.to_owned())
    }

    /// Without a mutant all claims have to hold; the seconds that a run with one may take.
    pub(super) fn check_unchanged(&self, mutants: &[Mutant]) -> Result<f64, String> {
        self.build()?;
        let started = Instant::now();
        for is_default in [false, true] {
            let of: Vec<&Mutant> =
                mutants.iter().filter(|mutant| mutant.is_default_profile == is_default).collect();
            if of.is_empty() {
                continue;
            }
            match self.run(&of, f64::INFINITY)? {
                Run::Fault(fault) => return Err(format!("without a mutant: {fault}")),
                Run::Report(report) => {
                    let failed = failed(&report);
                    if !failed.is_empty() {
                        return Err(format!("without a mutant these fail: {}", failed.join(", ")));
                    }
                }
            }
        }
        Ok(PATIENCE.0 * started.elapsed().as_secs_f64() + PATIENCE.1)
    }

    /// Runs the cases of these mutants and gives each its own failed claims.
    pub(super) fn judge(&self, round: &[&Mutant], limit: f64) -> Result<Vec<Outcome>, String> {
        Ok(match self.run(round, limit)? {
            Run::Fault(fault) => round.iter().map(|_| Outcome::fault(fault.clone())).collect(),
            Run::Report(report) => round.iter().map(|mutant| of_mutant(&report, mutant)).collect(),
        })
    }

    fn run(&self, mutants: &[&Mutant], limit: f64) -> Result<Run, String> {
        let out = self.tree.join("target").join("verify");
        let report = out.join("report.json");
        // What an earlier run left is not this one's.
        let _ = std::fs::remove_file(&report);
        let filters: BTreeSet<&String> =
            mutants.iter().flat_map(|mutant| &mutant.filters).collect();
        let mut command = Command::new(self.binary());
        command.arg("verify").args(filters).arg("--out").arg(&out);
        if mutants.iter().all(|mutant| !mutant.is_default_profile) {
            command.arg("--quick");
        }
        command
            .current_dir(&self.tree)
            .env("CARGO_MANIFEST_DIR", self.tree.join("tests"))
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        if let Some(fault) = ended_within(&mut command, limit)? {
            return Ok(Run::Fault(fault));
        }
        Ok(match read(&report) {
            Ok(report) => Run::Report(report),
            Err(error) => Run::Fault(format!("the proof ended without a report: {error}")),
        })
    }

    fn binary(&self) -> PathBuf {
        let name = format!("verification{}", std::env::consts::EXE_SUFFIX);
        self.target.join("mutant").join(name)
    }
}

/// Why the program was ended, if it was.
fn ended_within(command: &mut Command, limit: f64) -> Result<Option<String>, String> {
    let started = Instant::now();
    let mut child = command.spawn().map_err(|error| format!("cannot start the proof: {error}"))?;
    loop {
        match child.try_wait() {
            Ok(Some(_)) => return Ok(None),
            Ok(None) if started.elapsed().as_secs_f64() > limit => {
                let _ = child.kill().and_then(|()| child.wait().map(|_| ()));
                return Ok(Some(format!("did not end within {limit:.0} s")));
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(100)),
            Err(error) => return Err(format!("cannot wait for the proof: {error}")),
        }
    }
}

fn read(path: &Path) -> Result<Value, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    serde_json::from_str(&text).map_err(|error| error.to_string())
}

/// The ids of all failed claims.
fn failed(report: &Value) -> Vec<&str> {
    let cases = report["cases"].as_array().into_iter().flatten();
    let claims = cases.flat_map(|case| case["claims"].as_array().into_iter().flatten());
    claims
        .filter(|claim| claim["passed"] == false)
        .filter_map(|claim| claim["id"].as_str())
        .collect()
}

/// The failed claims of the cases of a mutant, by kind.
fn of_mutant(report: &Value, mutant: &Mutant) -> Outcome {
    let mut outcome = Outcome::default();
    let mut firsts: [Option<&str>; 4] = [None; 4];
    let cases = report["cases"].as_array().into_iter().flatten();
    for case in cases.filter(|case| mutant.is_of(case["id"].as_str().unwrap_or_default())) {
        for claim in case["claims"].as_array().into_iter().flatten() {
            if claim["passed"] != false {
                continue;
            }
            let id = claim["id"].as_str().unwrap_or_default();
            let (rank, count) = match claim["kind"].as_str() {
                _ if id.ends_with("/ran") => (2, &mut outcome.stopped),
                Some("accuracy") => (0, &mut outcome.accuracy),
                Some("structural") => (1, &mut outcome.structure),
                _ => (3, &mut outcome.regression),
            };
            *count += 1;
            firsts[rank].get_or_insert(id);
        }
    }
    let first = firsts.into_iter().flatten().next().unwrap_or("no claim failed");
    Outcome { first: first.to_owned(), ..outcome }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::mutant::tests::mutant;
    use super::*;

    #[test]
    fn failed_claims_count_for_their_kind_and_for_the_mutants_own_cases() {
        let claim =
            |id: &str, kind: &str, passed: bool| json!({"id": id, "kind": kind, "passed": passed});
        let report = json!({"cases": [
            {"id": "smpm/disks", "claims": [
                claim("smpm/disks/bound", "regression-bound", false),
                claim("smpm/disks/bits", "structural", false),
                claim("smpm/disks/energy", "accuracy", false),
                claim("smpm/disks/mass", "accuracy", true),
            ]},
            {"id": "smpm/trust", "claims": [claim("smpm/trust/value", "accuracy", false)]},
        ]});
        assert_eq!(failed(&report).len(), 4);
        let outcome = of_mutant(&report, &mutant("x", "smpm", "smpm/disks"));
        let expected = Outcome {
            accuracy: 1,
            structure: 1,
            regression: 1,
            first: "smpm/disks/energy".to_owned(),
            ..Outcome::default()
        };
        assert_eq!(outcome, expected);
        let stopped = json!({"cases": [{"id": "smpm/disks", "claims": [
            claim("smpm/disks/ran", "structural", false)
        ]}]});
        assert_eq!(of_mutant(&stopped, &mutant("x", "smpm", "smpm/disks")).stopped, 1);
    }

    #[test]
    fn a_program_that_does_not_end_is_ended() {
        let fault = ended_within(Command::new("sleep").arg("60"), 0.2).unwrap();
        assert_eq!(fault.as_deref(), Some("did not end within 0 s"));
        assert_eq!(ended_within(&mut Command::new("true"), 60.0).unwrap(), None);
    }
}
