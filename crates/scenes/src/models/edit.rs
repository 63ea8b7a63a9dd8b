//! Pieces from which kinds of scenes make their ingredients.

use serde::Serialize;
use serde_json::{Map, Value};

use super::ingredient::Ingredient;
use crate::ladder::keys;
use crate::scene::Scene;

/// The ingredients of a scene, listed from its type; none where it is no such scene.
#[must_use]
pub fn of<T: Scene>(
    scene: &Map<String, Value>,
    list: impl FnOnce(&T) -> Vec<Ingredient>,
) -> Vec<Ingredient> {
    let scene = T::from_keys(&Value::Object(scene.clone()));
    scene.as_ref().map_or_else(|_| Vec::new(), list)
}

/// The scene after a change; `None` where `change` finds nothing to change.
#[must_use]
pub fn changed<T: Clone>(scene: &T, change: impl FnOnce(&mut T) -> bool) -> Option<T> {
    let mut scene = scene.clone();
    change(&mut scene).then_some(scene)
}

/// Replaces a value; `false` where it is this one already.
pub fn replace<T: PartialEq>(place: &mut T, value: T) -> bool {
    let is_other = *place != value;
    *place = value;
    is_other
}

/// An ingredient that loses no state, where the scene has it.
#[must_use]
pub fn ingredient(name: impl Into<String>, scene: Option<impl Serialize>) -> Option<Ingredient> {
    Some(Ingredient { name: name.into(), scene: keys(&scene?).ok()?, states_lost: 0 })
}
