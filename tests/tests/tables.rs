//! The tables that the command line reads are well formed.
//!
//! They are tested from outside: a unit test that names a table compiles every case in it a second time.

use std::collections::BTreeSet;
use std::path::Path;

use scenes::schema;
use verification::case::Profile;
use verification::{cases, verify};

#[test]
fn the_cases_have_well_formed_names_of_their_own() -> Result<(), verify::TableError> {
    verify::check_table(cases::ALL)
}

#[test]
fn each_mutant_names_cases_that_its_profile_runs() {
    let text = include_str!("../../xtask/src/audit/mutants.json");
    let mutants: Vec<serde_json::Value> = serde_json::from_str(text).unwrap();
    for mutant in mutants {
        let filters = mutant["verify"].as_array().cloned().unwrap_or_default();
        let filters: Vec<String> =
            filters.iter().map(|filter| filter.as_str().unwrap().to_owned()).collect();
        let profile = match mutant.get("profile") {
            Some(name) => Profile::named(name.as_str().unwrap()).unwrap(),
            None => Profile::Quick,
        };
        if !filters.is_empty() {
            let selected = verify::select(cases::ALL, &filters, profile);
            assert!(selected.is_ok(), "{}: {:?}", mutant["name"], selected.err());
        }
    }
}

#[test]
fn names_of_scenes_are_unique() {
    let names: Vec<&str> = scenes::ALL.iter().map(|kind| kind.solver).collect();
    assert!(!names.is_empty());
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
}

/// Also that every number states its unit and every key has an example, and that the built-in scenes fit their schemas: else there
/// are no pages.
#[test]
fn the_recorded_pages_of_scenes_are_those_that_the_types_and_scenes_make() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let documents = schema::documents(scenes::ALL, &root.join("tests/scenes"));
    let documents = documents.unwrap_or_else(|error| panic!("{error}"));
    // A schema and a page for each kind of scene, and the page that lists them.
    assert_eq!(documents.len(), 2 * scenes::ALL.len() + 1);
    for schema::Document { path, text } in documents {
        let recorded = std::fs::read_to_string(root.join("docs").join(&path)).unwrap_or_default();
        let path = path.display();
        assert!(recorded == text, "docs/{path} is behind; run: cargo xtask schema --record");
    }
}
