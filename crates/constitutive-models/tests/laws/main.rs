//! Laws of the constitutive models: closed forms, differences for every parameter, the print of the source.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod equations_of_state;
mod johnson_cook_point;
mod materials;
mod published;
#[path = "../../../perturbation-moments/tests/responses/mod.rs"]
mod responses;
mod return_mapping;
