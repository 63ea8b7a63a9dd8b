//! Snapshots of particle-store.
#![no_main]

#[path = "../../../crates/particle-store/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_read!(any_input::snapshot(), any_input::is_read_or_refused);
