//! Two bodies of smpm and their first steps.
#![no_main]

#[path = "../../../crates/smpm/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::bodies(), any_input::bodies_start);
