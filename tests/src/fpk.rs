//! Density problems: what the cases, scenes and charts of `fpk-sph` share.

pub mod density;
pub mod monte_carlo;
pub mod problem;
pub mod reference;
pub mod scene;
