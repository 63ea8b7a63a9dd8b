//! Paths of sde-integrators with steps of their own choice.
#![no_main]

#[path = "../../../crates/sde-integrators/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::adaptive_path(), any_input::adapts);
