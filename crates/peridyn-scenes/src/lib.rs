#![doc = include_str!("../README.md")]

pub mod constraints;
pub mod crack_inference;
mod keys;
pub mod points;
mod procedure;
pub mod progress;
mod retired;
pub mod run;
mod scene_plate;
pub mod scene_problem;
pub mod sources;

pub(crate) use self::keys::positive;
pub use self::keys::{scene, scene_body, scene_dynamics, scene_field, scene_load};
