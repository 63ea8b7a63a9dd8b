//! Points as VTK writes them.
#![no_main]

#[path = "../../../crates/scenes/tests/any_input/changes.rs"]
mod changes;
#[path = "../../../crates/scenes/tests/any_input/points.rs"]
mod points;

fuzz_targets::fuzz_read!(points::COMPRESSED.as_bytes().to_vec(), points::grid);
