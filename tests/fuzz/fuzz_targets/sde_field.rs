//! Fields of sde-integrators by four factors.
#![no_main]

#[path = "../../../crates/sde-integrators/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::field(), any_input::steps_by_every_factor);
