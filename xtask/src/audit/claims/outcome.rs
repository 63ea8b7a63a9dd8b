//! Outcomes of mutants, kept from one run of the audit to the next.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

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

/// Outcomes by the name of the mutant, with the commit they were found at.
#[derive(Debug, Default)]
pub(super) struct Outcomes {
    path: PathBuf,
    kept: BTreeMap<String, (String, Outcome)>,
}

impl Outcomes {
    /// None where there is no file, or one that cannot be read.
    pub(super) fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let value: Value = serde_json::from_str(&text).unwrap_or_default();
        let kept = value.as_object().into_iter().flatten();
        let kept = kept.map(|(name, value)| (name.clone(), from_json(value))).collect();
        Self { path: path.to_owned(), kept }
    }

    pub(super) fn keep(&mut self, name: &str, commit: String, outcome: Outcome) {
        self.kept.insert(name.to_owned(), (commit, outcome));
    }

    pub(super) fn write(&self) -> Result<(), String> {
        let all: serde_json::Map<String, Value> =
            self.kept.iter().map(|(name, kept)| (name.clone(), to_json(kept))).collect();
        std::fs::write(&self.path, format!("{:#}\n", Value::Object(all)))
            .map_err(|error| format!("{}: {error}", self.path.display()))
    }

    /// The commit and the outcome, if the mutant was run.
    pub(super) fn of(&self, mutant: &Mutant) -> Option<&(String, Outcome)> {
        self.kept.get(&mutant.name)
    }

    pub(super) fn is_caught(&self, mutant: &Mutant) -> bool {
        self.of(mutant).is_some_and(|(_, outcome)| outcome.is_caught(mutant.breaks))
    }
}

fn to_json((commit, outcome): &(String, Outcome)) -> Value {
    let Outcome { accuracy, structure, regression, stopped, first, fault, seconds } = outcome;
    json!({
        "commit": commit,
        "accuracy": accuracy,
        "structure": structure,
        "regression": regression,
        "stopped": stopped,
        "first": first,
        "fault": fault,
        "seconds": seconds,
    })
}

fn from_json(value: &Value) -> (String, Outcome) {
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
    (text("commit"), outcome)
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn outcomes_survive_writing_and_reading() {
        let path = std::env::temp_dir().join(format!("outcomes-{}.json", std::process::id()));
        let outcome =
            Outcome { accuracy: 2, first: "a/b/c".into(), seconds: 1.5, ..Outcome::default() };
        let mut outcomes = Outcomes::read(&path);
        outcomes.keep("x", "1234".into(), outcome.clone());
        outcomes.write().unwrap();
        assert_eq!(Outcomes::read(&path).kept["x"], ("1234".to_owned(), outcome));
        std::fs::remove_file(&path).unwrap();
    }
}
