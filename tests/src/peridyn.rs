//! Bodies of bonds: what the cases, scenes and charts of `peridyn-sde` share.

pub mod background;
pub mod first_passage;
pub mod lattice;
pub mod memory;
pub mod network;
pub mod notched_plate;
pub mod one_bond;
pub mod plate;
pub mod points;
pub mod rest;
pub mod scene;
pub mod scene_body;
pub mod scene_dynamics;
pub mod scene_field;
mod scene_plate;
pub mod scene_problem;
pub mod stationary;
