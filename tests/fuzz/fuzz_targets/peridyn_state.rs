//! Saved states of peridyn-sde with other numbers, and a step from them.
#![no_main]

#[path = "../../../crates/peridyn-sde/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::forged(), any_input::goes_on_or_is_refused);
