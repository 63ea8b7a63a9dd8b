//! A hysteretic oscillator of fpk-sph and its first step.
#![no_main]

#[path = "../../../crates/fpk-sph/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::hysteretic(), any_input::hysteretic_starts);
