//! Density problems: what the cases, scenes and charts of `fpk-sph` share.

mod cholesky;
pub mod density;
mod discrete_gaussian;
pub mod grid;
mod grid_config;
pub mod lattice_scene;
pub mod law_scene;
pub mod linear_moments;
pub mod linearisation;
pub mod method_scene;
pub mod monte_carlo;
pub mod paths;
pub mod plane_density;
pub mod problem;
pub mod reference;
mod remap;
pub mod scene;
mod scene_examples;
pub mod scene_system;
pub mod scheme_scene;
pub mod structure_scene;
pub mod system_scene;
pub mod tail;
