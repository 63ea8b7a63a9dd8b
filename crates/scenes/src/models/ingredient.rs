//! What can be left out of a scene.

use serde_json::{Map, Value};

/// Something of a scene that can be left out, such as a damper, a filter of the noise, a random parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Ingredient {
    /// Its name, e.g. `the damper`.
    pub name: String,
    /// The scene without it.
    pub scene: Map<String, Value>,
    /// How many states the scene lost at their end: powers of moments are shorter by as many.
    pub states_lost: usize,
}
