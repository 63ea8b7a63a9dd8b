//! Density problems and their references.

pub mod linear_moments;
pub mod methods;
pub mod mixture;
pub mod oscillator;
pub mod problem;
pub mod reference;
