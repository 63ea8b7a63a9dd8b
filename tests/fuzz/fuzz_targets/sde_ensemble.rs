//! Ensembles of sde-integrators by fifteen pairs of a system and a method.
#![no_main]

#[path = "../../../crates/sde-integrators/tests/any_input.rs"]
mod any_input;

fuzz_targets::fuzz_drawn!(any_input::ensemble(), any_input::is_followed_by_every_method);
