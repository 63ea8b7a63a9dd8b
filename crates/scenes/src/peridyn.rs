//! Crack scenes: their types and their execution.

mod named;
pub mod points;
mod positive;
pub mod run;
pub mod scene;
pub mod scene_body;
pub mod scene_dynamics;
pub mod scene_field;
mod scene_plate;
pub mod scene_problem;
