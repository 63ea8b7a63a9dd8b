//! Points as lines of numbers.
#![no_main]

#[path = "../../../crates/scenes/tests/any_input/changes.rs"]
mod changes;
#[path = "../../../crates/scenes/tests/any_input/points.rs"]
mod points;

fuzz_targets::fuzz_read!(points::CSV.as_bytes().to_vec(), points::lines);
