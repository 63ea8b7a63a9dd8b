//! Each method against closed forms, and what it refuses.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod grid;
mod linearisation;
mod systems;
mod tails;
