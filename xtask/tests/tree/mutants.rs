//! Every mutant of `cargo xtask audit claims` still applies, and the cases that have to catch it exist.

use std::collections::BTreeSet;
use std::fs;

use crate::folder::{root, texts};
use serde_json::Value;

/// The solvers and shared crates that have cases.
const CRATES: [&str; 14] = [
    "constitutive-models",
    "fpk-sph",
    "mpi-ensembles",
    "neighbour-search",
    "particle-store",
    "peridyn-sde",
    "perturbation-moments",
    "random-fields",
    "random-vibration",
    "sde-integrators",
    "smoothing-kernels",
    "smpm",
    "uq-estimators",
    "vibrating-systems",
];

fn mutants() -> Vec<Value> {
    let path = root().join("xtask/src/audit/mutants.json");
    let text = fs::read_to_string(path).expect("mutants.json");
    serde_json::from_str(&text).expect("a list of mutants")
}

fn word<'a>(mutant: &'a Value, key: &str) -> &'a str {
    mutant[key].as_str().unwrap_or_default()
}

/// Why a mutant does not apply, if it does not.
fn fault(mutant: &Value) -> Option<String> {
    let (file, text) = (word(mutant, "file"), word(mutant, "text"));
    let source = fs::read_to_string(root().join(file)).unwrap_or_default();
    let is_of_crate = file.starts_with(&format!("crates/{}/src/", word(mutant, "crate")));
    let count = if text.is_empty() { 0 } else { source.matches(text).count() };
    let is_changed = text != word(mutant, "replacement");
    (!is_of_crate || count != 1 || !is_changed)
        .then(|| format!("{}: {count} times in {file}", word(mutant, "name")))
}

#[test]
fn every_mutant_still_applies() {
    let faults: Vec<String> = mutants().iter().filter_map(fault).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn a_mutant_whose_text_is_gone_is_noticed() {
    let mut mutant = mutants().swap_remove(0);
    assert_eq!(fault(&mutant), None);
    mutant["text"] = "no such text".into();
    assert!(fault(&mutant).is_some_and(|fault| fault.contains("0 times")));
}

#[test]
fn names_differ_and_every_crate_with_cases_has_a_mutant() {
    let mutants = mutants();
    let names: BTreeSet<&str> = mutants.iter().map(|mutant| word(mutant, "name")).collect();
    assert_eq!(names.len(), mutants.len());
    let crates: BTreeSet<&str> = mutants.iter().map(|mutant| word(mutant, "crate")).collect();
    assert_eq!(crates, BTreeSet::from(CRATES));
    assert!(mutants.len() >= 40, "{}", mutants.len());
}

#[test]
fn the_cases_and_tests_that_have_to_catch_a_mutant_exist() {
    let sources = texts(&root().join("tests/src/cases"), ".rs").expect("the cases");
    let text: String = sources.into_iter().map(|(_, text)| text).collect();
    for mutant in mutants() {
        let name = word(&mutant, "name");
        let list = |key: &str| mutant[key].as_array().cloned().unwrap_or_default();
        let (filters, packages) = (list("verify"), list("test"));
        assert!(!filters.is_empty() || !packages.is_empty(), "{name}");
        for filter in filters {
            let id = format!("id: \"{}", filter.as_str().unwrap_or_default());
            assert!(text.contains(&id), "{name}: no case begins with {filter}");
        }
        for package in packages {
            let tests =
                root().join("crates").join(package.as_str().unwrap_or_default()).join("tests");
            assert!(tests.is_dir(), "{name}: {package} has no tests");
        }
    }
}
