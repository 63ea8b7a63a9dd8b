//! Scenes with known answers, by solver.

mod density_methods;
mod linear_systems;
mod scalar_systems;
mod stationary_oscillators;

use crate::Family;

/// All families.
pub const ALL: &[Family] = &[
    linear_systems::FAMILY,
    scalar_systems::WELLS,
    scalar_systems::CLOSED,
    stationary_oscillators::FAMILY,
];
