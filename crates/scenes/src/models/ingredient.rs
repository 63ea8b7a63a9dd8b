//! An ingredient that can be left out of a scene.

use serde_json::{Map, Value};

/// An ingredient that can be left out, such as a damper, a noise filter or a random parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Ingredient {
    /// Its name, e.g. `the damper`.
    pub name: String,
    /// The scene without it.
    pub scene: Map<String, Value>,
    /// Number of trailing states removed: powers of moments become shorter by that number.
    pub states_lost: usize,
}
