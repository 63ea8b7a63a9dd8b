#![doc = include_str!("../README.md")]

pub mod crack_inference;
pub mod held;
mod named;
pub mod points;
mod positive;
mod procedure;
mod retired;
pub mod run;
pub mod scene;
pub mod scene_body;
mod scene_check;
pub mod scene_dynamics;
pub mod scene_field;
pub mod scene_load;
mod scene_plate;
pub mod scene_problem;
pub mod so_far;
pub mod sources;
