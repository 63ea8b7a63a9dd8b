//! The tables that the command line reads are well formed.
//!
//! They are tested from outside: a unit test that names a table compiles every case in it a second time.

use std::collections::BTreeSet;

use verification::{cases, charts, scenes, verify};

#[test]
fn the_cases_have_well_formed_names_of_their_own() -> Result<(), verify::TableError> {
    verify::check_table(cases::ALL)
}

#[test]
fn names_of_charts_sweeps_and_scenes_are_unique() {
    let names = |table: &[charts::ChartKind]| table.iter().map(|kind| kind.name).collect();
    let solvers = scenes::ALL.iter().map(|kind| kind.solver).collect();
    for names in [names(charts::ALL), names(charts::STABILITY), solvers] {
        let names: Vec<&str> = names;
        assert!(!names.is_empty());
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
    }
}
