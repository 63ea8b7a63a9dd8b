//! An ingredient that can be left out of a scene.

use serde_json::{Map, Value};

/// An ingredient that can be left out, such as a damper, a noise filter or a random parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Ingredient {
    /// Its name, e.g. `the damper`.
    pub name: String,
    /// The scene without it.
    pub scene: Map<String, Value>,
    /// Ids of quantities that have another id in that scene, each with it; none for a quantity that the scene does not have.
    pub renamed: Vec<(String, Option<String>)>,
}
