#![doc = include_str!("../README.md")]

pub mod building;
mod checks;
pub mod density;
pub mod integrator_scene;
pub mod lattice_scene;
pub mod law_scene;
pub mod method_scene;
pub mod monte_carlo;
mod path_blocks;
pub mod paths;
pub mod plane_density;
mod retired;
pub mod run;
pub mod scene;
pub mod scheme_scene;
pub mod sources;
pub mod structure_scene;
pub mod system;
pub mod system_scene;
