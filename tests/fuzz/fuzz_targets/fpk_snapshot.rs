//! Snapshots of fpk-sph, and a step from them.
#![no_main]

#[path = "../../../crates/fpk-sph/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_read!(any_input::snapshot(), any_input::goes_on_or_is_refused);
