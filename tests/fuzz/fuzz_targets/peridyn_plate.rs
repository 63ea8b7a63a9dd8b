//! A plate of peridyn-sde and its first step.
#![no_main]

#[path = "../../../crates/peridyn-sde/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::plate(), any_input::starts);
