//! Helpers with which scene kinds define their ingredients.

use serde::Serialize;
use serde_json::{Map, Value};

use super::ingredient::Ingredient;
use crate::ladder::keys;
use crate::scene::Scene;

/// Lists the ingredients of a scene from its type; empty if the scene is of another type.
#[must_use]
pub fn of<T: Scene>(
    scene: &Map<String, Value>,
    list: impl FnOnce(&T) -> Vec<Ingredient>,
) -> Vec<Ingredient> {
    let scene = T::from_keys(&Value::Object(scene.clone()));
    scene.as_ref().map_or_else(|_| Vec::new(), list)
}

/// The scene after a change; `None` if `change` returns false.
#[must_use]
pub fn changed<T: Clone>(scene: &T, change: impl FnOnce(&mut T) -> bool) -> Option<T> {
    let mut scene = scene.clone();
    change(&mut scene).then_some(scene)
}

/// Replaces a value; `false` if it was equal already.
pub fn replace<T: PartialEq>(place: &mut T, value: T) -> bool {
    let is_other = *place != value;
    *place = value;
    is_other
}

/// An ingredient without which all quantities keep their ids, if the scene has it.
#[must_use]
pub fn ingredient(name: impl Into<String>, scene: Option<impl Serialize>) -> Option<Ingredient> {
    Some(Ingredient { name: name.into(), scene: keys(&scene?).ok()?, renamed: Vec::new() })
}
