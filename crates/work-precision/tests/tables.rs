//! The tables that the command line reads are well formed.

use std::collections::BTreeSet;

use work_precision::charts;

#[test]
fn names_of_charts_and_sweeps_are_unique() {
    for table in [charts::ALL, charts::MODELS, charts::STABILITY] {
        let names: BTreeSet<&str> = table.iter().map(|kind| kind.name).collect();
        assert!(!names.is_empty());
        assert_eq!(names.len(), table.len());
    }
}
