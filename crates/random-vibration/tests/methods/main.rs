//! Each method compared with closed forms, and its errors for invalid input.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod custom_pairwise;
mod grid;
mod guided;
mod linear_passages;
mod linearisation;

mod systems;
mod tails;
