//! Density problems, their references, and the rivals of `fpk-sph`.

mod cholesky;
mod discrete_gaussian;
pub mod grid;
mod grid_config;
pub mod linear_moments;
pub mod linearisation;
pub mod methods;
pub mod oscillator;
pub mod problem;
pub mod reference;
mod remap;
pub mod tail;
