//! A kind of scenes with known answers.

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
