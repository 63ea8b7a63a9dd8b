//! A damped oscillator of fpk-sph and its first step.
#![no_main]

#[path = "../../../crates/fpk-sph/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::damped(), any_input::damped_starts);
