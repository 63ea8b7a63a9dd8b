//! What the cases of `perturbation-moments` share: the reference and its responses.

pub mod reference;
pub mod responses;

#[path = "../../crates/perturbation-moments/tests/responses/mod.rs"]
mod closed_forms;
