//! Scenes with known answers, by solver.

mod density_methods;
mod linear_systems;
mod scalar_systems;
mod stationary_oscillators;

use fpk_scenes::scene::FpkScene;
use fpk_scenes::system::System;
use serde_json::Value;

use crate::{Draw, Truth};

/// Scenes of one kind whose answers are known.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// Its name.
    pub name: &'static str,
    /// How the answers are known.
    pub known_by: &'static str,
    /// Part of all scenes (no unit).
    pub weight: f64,
    /// Draws a scene and the name of its method; hostile if so asked.
    pub draw: fn(&mut Draw, bool) -> (Value, &'static str),
    /// What is known of the answers of a scene; none of a scene of another kind.
    pub truths: fn(&FpkScene, &System) -> Option<Vec<Truth>>,
}

/// All families.
pub const ALL: &[Family] = &[
    linear_systems::FAMILY,
    scalar_systems::WELLS,
    scalar_systems::CLOSED,
    stationary_oscillators::FAMILY,
];
