//! What must hold of bonds and forces, whatever the body.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod bridge;
mod constants;
mod custom_body;
mod custom_law;
mod disorder;
mod dispersion;
mod dynamics;
mod fixtures;
mod forces;
mod given;
mod halted;
mod memory;
mod mobility;
mod note;
mod paths;
mod quasi_static;
mod registers;
mod slow_ensemble;
mod solid;
mod solid_failure;
mod statics;
mod swing;
mod weakest_link;
