//! Maxima of paths of sde-integrators.
#![no_main]

#[path = "../../../crates/sde-integrators/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::watched(), any_input::has_maxima);
