//! A kind of scenes with known answers.

use std::time::Duration;

use scenes::RunError;
use serde_json::Value;

use crate::{Draw, Truth, Verdict};

/// Numbers of a scene beside their truths, by a run no longer than allowed.
pub type Judge = fn(&Value, &[Truth], Duration) -> Result<Vec<Verdict>, RunError>;

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
    pub truths: fn(&Value) -> Option<Vec<Truth>>,
    /// Runs a scene, no longer than allowed, and compares its numbers with what is known.
    pub judge: Judge,
}
