//! Quasi-static equilibrium.

mod band;
mod config;
mod quasi_static;
mod solver;
mod statics;
mod two_level;

pub use config::EquilibriumConfig;
pub use quasi_static::{Breakage, LoadStep, NextBreakage, QuasiStatic, envelope};
pub use statics::Solved;
