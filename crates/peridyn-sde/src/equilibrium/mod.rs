//! Quasi-static equilibrium: the path of a body under a load that grows slowly, event by event, for small strains.
//!
//! A body is known by its trait alone. Nothing here knows time or noise; the times of a loading are load factors.

mod band;
mod config;
mod quasi_static;
mod solver;
mod statics;
mod two_level;

pub use config::EquilibriumConfig;
pub use quasi_static::{Breakage, NextBreakage, QuasiStatic, envelope};
pub use statics::Solved;
