//! Outcomes of mutants, kept from one run of the audit to the next.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::mutant::{Breaks, Mutant};

/// The failed claims of a mutant's own cases.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Outcome {
    pub(super) accuracy: u64,
    pub(super) structure: u64,
    pub(super) regression: u64,
    /// Cases that ended in an error.
    pub(super) stopped: u64,
    /// The first failed claim of the kind that counts most.
    pub(super) first: String,
    /// Why there are no claims; empty otherwise.
    pub(super) fault: String,
    /// Its share of the time of its build and run (s).
    pub(super) seconds: f64,
}

impl Outcome {
    pub(super) fn not_compiled(error: &str) -> Self {
        Self { fault: format!("does not compile: {error}"), ..Self::default() }
    }

    pub(super) fn fault(words: String) -> Self {
        Self { fault: words, ..Self::default() }
    }

    /// A regression bound alone catches nothing.
    pub(super) fn is_caught(&self, breaks: Breaks) -> bool {
        let by_structure = breaks == Breaks::Structure && self.structure > 0;
        self.fault.is_empty() && (self.accuracy > 0 || self.stopped > 0 || by_structure)
    }

    /// One line.
    pub(super) fn words(&self) -> String {
        let Self { accuracy, structure, regression, stopped, first, fault, seconds } = self;
        if !fault.is_empty() {
            return fault.clone();
        }
        format!(
            "{accuracy} of accuracy, {structure} structural, {regression} regression bounds, \
             {stopped} stopped; {first} ({seconds:.0} s)"
        )
    }
}

/// An outcome, with what it was found for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kept {
    /// Commit of the tree.
    pub(super) commit: String,
    /// [`Sources::hash`](super::subject::Sources::hash) of the mutant.
    pub(super) hash: String,
    pub(super) outcome: Outcome,
}

/// Outcomes by the name of the mutant.
#[derive(Debug, Default)]
pub(super) struct Outcomes {
    kept: BTreeMap<String, Kept>,
    /// The hashes of all mutants now: an outcome of another hash is out of date.
    hashes: BTreeMap<String, String>,
}

impl Outcomes {
    /// Those of these files, none where there is no file or one that cannot be read. Of two for a mutant the one that is up to
    /// date counts, or the later.
    pub(super) fn read(files: &[&Path], hashes: BTreeMap<String, String>) -> Self {
        let mut outcomes = Self { kept: BTreeMap::new(), hashes };
        for file in files {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            let value: Value = serde_json::from_str(&text).unwrap_or_default();
            for (name, value) in value.as_object().into_iter().flatten() {
                let kept = from_json(value);
                if !outcomes.holds(name) || outcomes.hashes.get(name) == Some(&kept.hash) {
                    outcomes.kept.insert(name.clone(), kept);
                }
            }
        }
        outcomes
    }

    pub(super) fn keep(&mut self, mutant: &Mutant, commit: String, outcome: Outcome) {
        let hash = self.hashes.get(&mutant.name).cloned().unwrap_or_default();
        self.kept.insert(mutant.name.clone(), Kept { commit, hash, outcome });
    }

    pub(super) fn write(&self, file: &Path) -> Result<(), String> {
        let all: serde_json::Map<String, Value> =
            self.kept.iter().map(|(name, kept)| (name.clone(), to_json(kept))).collect();
        std::fs::write(file, format!("{:#}\n", Value::Object(all)))
            .map_err(|error| format!("{}: {error}", file.display()))
    }

    /// Whether an outcome is kept for the mutant, its source and its cases as they are.
    fn holds(&self, name: &str) -> bool {
        self.kept.get(name).is_some_and(|kept| self.hashes.get(name) == Some(&kept.hash))
    }

    /// The outcome of a mutant, if there is one for its source and its cases as they are.
    pub(super) fn of(&self, mutant: &Mutant) -> Option<&Kept> {
        self.kept.get(&mutant.name).filter(|_| self.holds(&mutant.name))
    }

    /// The last outcome of a mutant, also one for its source or its cases before a change.
    pub(super) fn last_of(&self, mutant: &Mutant) -> Option<&Kept> {
        self.kept.get(&mutant.name)
    }

    pub(super) fn is_caught(&self, mutant: &Mutant) -> bool {
        self.of(mutant).is_some_and(|kept| kept.outcome.is_caught(mutant.breaks))
    }
}

fn to_json(Kept { commit, hash, outcome }: &Kept) -> Value {
    let Outcome { accuracy, structure, regression, stopped, first, fault, seconds } = outcome;
    json!({
        "commit": commit,
        "hash": hash,
        "accuracy": accuracy,
        "structure": structure,
        "regression": regression,
        "stopped": stopped,
        "first": first,
        "fault": fault,
        "seconds": seconds,
    })
}

fn from_json(value: &Value) -> Kept {
    let text = |key: &str| value[key].as_str().unwrap_or_default().to_owned();
    let count = |key: &str| value[key].as_u64().unwrap_or_default();
    let outcome = Outcome {
        accuracy: count("accuracy"),
        structure: count("structure"),
        regression: count("regression"),
        stopped: count("stopped"),
        first: text("first"),
        fault: text("fault"),
        seconds: value["seconds"].as_f64().unwrap_or_default(),
    };
    Kept { commit: text("commit"), hash: text("hash"), outcome }
}

#[cfg(test)]
mod tests {
    use super::super::mutant::tests::mutant;
    use super::*;

    #[test]
    fn a_regression_bound_alone_catches_nothing() {
        let caught = |outcome: &Outcome| {
            [Breaks::Accuracy, Breaks::Structure].map(|breaks| outcome.is_caught(breaks))
        };
        let none = Outcome::default();
        assert_eq!(caught(&none), [false, false]);
        assert_eq!(caught(&Outcome { regression: 3, ..none.clone() }), [false, false]);
        assert_eq!(caught(&Outcome { structure: 1, ..none.clone() }), [false, true]);
        assert_eq!(caught(&Outcome { accuracy: 1, ..none.clone() }), [true, true]);
        assert_eq!(caught(&Outcome { stopped: 1, ..none }), [true, true]);
        assert_eq!(caught(&Outcome::not_compiled("type")), [false, false]);
    }

    fn hashes(hash: &str) -> BTreeMap<String, String> {
        BTreeMap::from([("x".to_owned(), hash.to_owned())])
    }

    #[test]
    fn outcomes_survive_writing_and_reading() {
        let path = std::env::temp_dir().join(format!("outcomes-{}.json", std::process::id()));
        let mutant = mutant("x", "smpm", "smpm");
        let outcome =
            Outcome { accuracy: 2, first: "a/b/c".into(), seconds: 1.5, ..Outcome::default() };
        let mut outcomes = Outcomes::read(&[&path], hashes("1"));
        assert_eq!(outcomes.of(&mutant), None);
        outcomes.keep(&mutant, "1234".into(), outcome.clone());
        outcomes.write(&path).unwrap();
        let expected = Kept { commit: "1234".into(), hash: "1".into(), outcome };
        assert_eq!(Outcomes::read(&[&path], hashes("1")).of(&mutant), Some(&expected));
        // Its source or its cases have changed since.
        assert_eq!(Outcomes::read(&[&path], hashes("2")).of(&mutant), None);
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn of_two_outcomes_the_one_of_today_counts() {
        let mutant = mutant("x", "smpm", "smpm");
        let file = |name: &str, hash: &str, accuracy: u64| {
            let path = std::env::temp_dir().join(format!("{name}-{}.json", std::process::id()));
            let mut outcomes = Outcomes::read(&[], hashes(hash));
            outcomes.keep(&mutant, "1234".into(), Outcome { accuracy, ..Outcome::default() });
            outcomes.write(&path).unwrap();
            path
        };
        let [a, b, c] = [file("two-a", "1", 1), file("two-b", "2", 2), file("two-c", "1", 3)];
        let found = |files: &[&Path]| {
            let outcomes = Outcomes::read(files, hashes("1"));
            outcomes.of(&mutant).map(|kept| kept.outcome.accuracy)
        };
        assert_eq!(found(&[&a, &b]), Some(1));
        assert_eq!(found(&[&b, &a]), Some(1));
        assert_eq!(found(&[&a, &b, &c]), Some(3));
        assert_eq!(found(&[&b]), None);
        for path in [a, b, c] {
            std::fs::remove_file(path).unwrap();
        }
    }
}
