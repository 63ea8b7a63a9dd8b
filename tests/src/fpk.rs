//! Density problems: what the cases, scenes and charts of `fpk-sph` share.

pub mod density;
pub mod linear_moments;
pub mod monte_carlo;
pub mod paths;
pub mod plane_density;
pub mod problem;
pub mod reference;
pub mod scene;
pub mod scene_system;
pub mod system_scene;
