//! Outcomes of mutants: their file, a table, and the page `docs/mutants.md`.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::mutant::Mutant;

/// What came of a mutant.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Verdict {
    /// By this claim or test.
    Caught(String),
    Survived,
    /// It did not compile, or did not end.
    Fault(String),
}

/// The verdict on a mutant, and of which commit it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outcome {
    pub(super) commit: String,
    pub(super) verdict: Verdict,
    /// Time of its build and its runs (s).
    pub(super) seconds: f64,
}

impl Outcome {
    /// One line.
    pub(super) fn words(&self) -> String {
        let words = match &self.verdict {
            Verdict::Caught(by) => format!("caught by {by}"),
            Verdict::Survived => "SURVIVED".to_owned(),
            Verdict::Fault(fault) => format!("NO RESULT: {fault}"),
        };
        format!("{words} ({:.0} s)", self.seconds)
    }
}

/// Outcomes by the name of the mutant, each with the hash of what it depends on.
#[derive(Debug, Default)]
pub(super) struct Outcomes {
    found: BTreeMap<String, (String, Outcome)>,
    /// The hashes of all mutants now.
    hashes: BTreeMap<String, String>,
}

impl Outcomes {
    /// Reads files, later ones over earlier ones; a file that is absent has no outcomes.
    pub(super) fn read(files: &[&Path], hashes: BTreeMap<String, String>) -> Self {
        let mut outcomes = Self { found: BTreeMap::new(), hashes };
        for file in files {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            let value: Value = serde_json::from_str(&text).unwrap_or_default();
            for (name, value) in value.as_object().into_iter().flatten() {
                let read = from_json(value);
                // An outcome that is still current is not replaced by one that is not.
                if !outcomes.is_current_name(name) || outcomes.hashes.get(name) == Some(&read.0) {
                    outcomes.found.insert(name.clone(), read);
                }
            }
        }
        outcomes
    }

    pub(super) fn insert(&mut self, mutant: &Mutant, outcome: Outcome) {
        let hash = self.hashes.get(&mutant.name).cloned().unwrap_or_default();
        self.found.insert(mutant.name.clone(), (hash, outcome));
    }

    pub(super) fn write(&self, file: &Path) -> Result<(), String> {
        let entry = |(name, outcome)| (String::clone(name), to_json(outcome));
        let all: serde_json::Map<String, Value> = self.found.iter().map(entry).collect();
        std::fs::write(file, format!("{:#}\n", Value::Object(all)))
            .map_err(|error| format!("{}: {error}", file.display()))
    }

    fn of(&self, mutant: &Mutant) -> Option<&Outcome> {
        self.found.get(&mutant.name).map(|(_, outcome)| outcome)
    }

    /// Whether the mutant has an outcome for its source and cases as they are.
    pub(super) fn is_current(&self, mutant: &Mutant) -> bool {
        self.is_current_name(&mutant.name)
    }

    fn is_current_name(&self, name: &str) -> bool {
        self.found.get(name).is_some_and(|(hash, _)| self.hashes.get(name) == Some(hash))
    }

    pub(super) fn is_caught(&self, mutant: &Mutant) -> bool {
        self.is_current(mutant)
            && self.of(mutant).is_some_and(|it| matches!(it.verdict, Verdict::Caught(_)))
    }
}

fn to_json((hash, outcome): &(String, Outcome)) -> Value {
    let (caught_by, fault) = match &outcome.verdict {
        Verdict::Caught(by) => (Some(by), None),
        Verdict::Survived => (None, None),
        Verdict::Fault(fault) => (None, Some(fault)),
    };
    json!({
        "commit": outcome.commit, "hash": hash, "caught_by": caught_by, "fault": fault,
        "seconds": outcome.seconds.round(),
    })
}

fn from_json(value: &Value) -> (String, Outcome) {
    let text = |key: &str| value[key].as_str().map(str::to_owned);
    let verdict = match (text("caught_by"), text("fault")) {
        (Some(by), _) => Verdict::Caught(by),
        (None, Some(fault)) => Verdict::Fault(fault),
        (None, None) => Verdict::Survived,
    };
    let seconds = value["seconds"].as_f64().unwrap_or_default();
    let outcome = Outcome { commit: text("commit").unwrap_or_default(), verdict, seconds };
    (text("hash").unwrap_or_default(), outcome)
}

/// Name, crate and physics of each mutant.
pub(super) fn list(mutants: &[Mutant]) -> String {
    let line = |m: &Mutant| format!("{:<28}{:<22}{}\n", m.name, m.package, m.what);
    mutants.iter().map(line).collect()
}

/// A line for each mutant.
pub(super) fn table(mutants: &[Mutant], outcomes: &Outcomes) -> String {
    let line = |mutant: &Mutant| {
        let words = outcomes.of(mutant).map_or("not run".to_owned(), Outcome::words);
        let before = if outcomes.is_current(mutant) { "" } else { ", before a change" };
        format!("{:<28}{words}{before}\n", mutant.name)
    };
    mutants.iter().map(line).collect()
}

const HEAD: &str = "\
Each mutant replaces one text in one file (`xtask/src/audit/mutants.json`). The workspace is built with it, then the tests of \
the packages and the cases of `verify` that it names are run. A mutant is caught if a test or a claim of accuracy fails or a case \
stops with an error; a mutant that breaks a structure, also by a structural claim. A regression bound alone catches nothing.

`cargo xtask audit claims --only NAME` repeats a row; *seconds* is the time of its build and its runs. An outcome counts as long \
as the mutant, the file that it changes and the files of its cases and tests stay the same; after a change of one of them it is \
*caught before*, at its *commit*. `cargo xtask audit claims --missing` runs those again.
";

const COLUMNS: &str =
    "| mutant | what it breaks | verdict | by | seconds | commit |\n|---|---|---|---|---|---|\n";

/// The page `docs/mutants.md`.
pub(super) fn render(mutants: &[Mutant], outcomes: &Outcomes) -> String {
    let verdict = |mutant: &Mutant| match (outcomes.of(mutant), outcomes.is_current(mutant)) {
        (None, _) => "not run",
        (Some(Outcome { verdict: Verdict::Caught(_), .. }), true) => "caught",
        (Some(Outcome { verdict: Verdict::Caught(_), .. }), false) => "caught before",
        (Some(Outcome { verdict: Verdict::Survived, .. }), _) => "SURVIVED",
        (Some(Outcome { verdict: Verdict::Fault(_), .. }), _) => "NO RESULT",
    };
    let count = |word: &str| mutants.iter().filter(|mutant| verdict(mutant) == word).count();
    let [caught, before, not_run] = ["caught", "caught before", "not run"].map(count);
    let mut page = format!(
        "# Mutants\n\nThis page says which wrong constants and signs the tests and claims of each crate detect. Written by \
         `cargo xtask audit claims --record`: {} mutants, {caught} caught, {before} caught before a change, {} survived, \
         {not_run} not run.\n\n{HEAD}",
        mutants.len(),
        mutants.len() - caught - before - not_run,
    );
    let mut crates: BTreeMap<&str, Vec<&Mutant>> = BTreeMap::new();
    for mutant in mutants {
        crates.entry(&mutant.package).or_default().push(mutant);
    }
    for (name, of) in &crates {
        page.extend(["\n## ", name, "\n\n", COLUMNS]);
        for mutant in of {
            let kind = if mutant.is_structural { " (structure)" } else { "" };
            let rest = outcomes.of(mutant).map_or("| | ".to_owned(), |outcome| {
                let by = match &outcome.verdict {
                    Verdict::Caught(words) | Verdict::Fault(words) => words.replace('|', "\\|"),
                    Verdict::Survived => String::new(),
                };
                format!("{by} | {:.0} | {}", outcome.seconds, outcome.commit)
            });
            let Mutant { name, what, .. } = mutant;
            page.extend([format!("| {name} | {what}{kind} | {} | {rest} |\n", verdict(mutant))]);
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mutant(name: &str) -> Mutant {
        let [package, what] = ["smpm", "a constant"].map(str::to_owned);
        Mutant { name: name.to_owned(), package, what, ..Mutant::default() }
    }

    fn outcome(verdict: Verdict) -> Outcome {
        Outcome { commit: "1234".into(), verdict, seconds: 2.0 }
    }

    fn hashes(hash: &str) -> BTreeMap<String, String> {
        ["a", "b", "c"].map(|name| (name.to_owned(), hash.to_owned())).into()
    }

    #[test]
    fn outcomes_survive_writing_and_reading_and_expire_with_their_hash() {
        let path = std::env::temp_dir().join(format!("outcomes-{}.json", std::process::id()));
        let mut outcomes = Outcomes::read(&[&path], hashes("1"));
        assert!(!outcomes.is_current(&mutant("a")));
        let caught = outcome(Verdict::Caught("`a/b`".into()));
        outcomes.insert(&mutant("a"), caught.clone());
        outcomes.insert(&mutant("b"), outcome(Verdict::Survived));
        outcomes.write(&path).unwrap();
        let again = Outcomes::read(&[&path], hashes("1"));
        assert_eq!(again.of(&mutant("a")), Some(&caught));
        assert!(again.is_caught(&mutant("a")) && !again.is_caught(&mutant("b")));
        let changed = Outcomes::read(&[&path], hashes("2"));
        assert!(changed.of(&mutant("a")).is_some() && !changed.is_caught(&mutant("a")));
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn the_page_counts_what_was_run_and_what_was_caught() {
        let mutants = ["a", "b", "c"].map(mutant);
        let mut outcomes = Outcomes::read(&[], hashes("1"));
        outcomes.insert(&mutants[0], outcome(Verdict::Caught("`smpm/x/y`".into())));
        outcomes.insert(&mutants[1], outcome(Verdict::Survived));
        let page = render(&mutants, &outcomes);
        for expected in [
            "3 mutants, 1 caught, 0 caught before a change, 1 survived, 1 not run.",
            "| a | a constant | caught | `smpm/x/y` | 2 | 1234 |",
            "| b | a constant | SURVIVED |  | 2 | 1234 |",
            "| c | a constant | not run | | |  |",
        ] {
            assert!(page.contains(expected), "{expected} is missing from\n{page}");
        }
        assert!(table(&mutants, &outcomes).starts_with("a                           caught by"));
    }
}
