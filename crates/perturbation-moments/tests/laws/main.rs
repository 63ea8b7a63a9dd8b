//! Derivatives and the moments made of them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

#[path = "../responses/mod.rs"]
mod responses;

mod differentiation;
mod moments;
