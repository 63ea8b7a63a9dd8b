//! Whether the recorded proof is older than its cases, scenes and references: by the commit that it names.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// What a proof is made from, beside the solvers: paths from the root of the workspace.
const SOURCES: [&str; 4] =
    ["tests/src/cases.rs", "tests/src/cases", "tests/reference", "tests/scenes"];
/// More changes than these are counted.
const NAMED: usize = 12;

/// What a record says of its making.
#[derive(Debug, PartialEq, Eq)]
struct Record {
    commit: String,
    cases: BTreeSet<String>,
}

impl Record {
    /// From the text of `docs/verification.json`; none from another text.
    fn read(text: &str) -> Option<Self> {
        let record: Value = serde_json::from_str(text).ok()?;
        let cases = record["cases"].as_object()?.keys().cloned().collect();
        Some(Self { commit: record["commit"].as_str()?.to_owned(), cases })
    }
}

/// A line on the record with the text `recorded`, for the `cases` that such a run has now, in the workspace at `root`.
pub(super) fn verdict(recorded: &str, name: &str, cases: &BTreeSet<String>, root: &Path) -> String {
    let Some(record) = Record::read(recorded) else {
        return format!("warning: {name} is stale: it does not say from which commit it is");
    };
    let added = cases.difference(&record.cases).map(|id| format!("case {id} added"));
    let removed = record.cases.difference(cases).map(|id| format!("case {id} removed"));
    let mut changes: Vec<String> = added.chain(removed).collect();
    match changed_files(root, &record.commit) {
        Some(files) => changes.extend(files.into_iter().map(|file| format!("{file} changed"))),
        None if changes.is_empty() => {
            return format!("warning: git does not know the commit {} of {name}", record.commit);
        }
        None => {}
    }
    if changes.is_empty() {
        return format!("{name} is up to date with cases, scenes and references");
    }
    let rest = changes.len().saturating_sub(NAMED);
    changes.truncate(NAMED);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    format!("warning: {name} is stale: {}{more}", changes.join(", "))
}

/// The sources that differ between a commit and the working tree; none where git cannot say.
fn changed_files(root: &Path, commit: &str) -> Option<Vec<String>> {
    let mut git = Command::new("git");
    git.arg("-C").arg(root).args(["diff", "--name-only", commit, "--"]).args(SOURCES);
    let output = git.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(recorded: &str, cases: &[&str]) -> String {
        let cases = cases.iter().map(|&id| id.to_owned()).collect();
        verdict(recorded, "RECORD", &cases, Path::new("/"))
    }

    #[test]
    fn cases_that_came_and_went_are_named() {
        let recorded = r#"{"commit": "0", "cases": {"a/b": {}, "a/c": {}}, "claims": {}}"#;
        assert_eq!(
            of(recorded, &["a/b", "a/d"]),
            "warning: RECORD is stale: case a/d added, case a/c removed"
        );
        assert_eq!(
            of(recorded, &["a/b", "a/c"]),
            "warning: git does not know the commit 0 of RECORD"
        );
        let many: Vec<String> = (0..20).map(|k| format!("b/{k}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert!(of(recorded, &many).ends_with(" and 10 more"), "{}", of(recorded, &many));
        assert!(of("{}", &[]).contains("from which commit"));
    }
}
