//! Pieces from which kinds of scenes make their ingredients.

use serde_json::{Map, Value};

use super::ingredient::Ingredient;

/// The scene with another value at a JSON pointer; none where there is nothing yet.
#[must_use]
pub fn with(scene: &Map<String, Value>, pointer: &str, value: Value) -> Option<Map<String, Value>> {
    let mut whole = Value::Object(scene.clone());
    *whole.pointer_mut(pointer)? = value;
    match whole {
        Value::Object(scene) => Some(scene),
        _ => None,
    }
}

/// The scene without a key of the object at a JSON pointer; none where it is not there.
#[must_use]
pub fn without(scene: &Map<String, Value>, pointer: &str, key: &str) -> Option<Map<String, Value>> {
    let mut whole = Value::Object(scene.clone());
    let object = match pointer {
        "" => whole.as_object_mut()?,
        pointer => whole.pointer_mut(pointer)?.as_object_mut()?,
    };
    object.remove(key)?;
    match whole {
        Value::Object(scene) => Some(scene),
        _ => None,
    }
}

/// An ingredient that loses no state, where the scene has it.
#[must_use]
pub fn ingredient(
    name: impl Into<String>,
    scene: Option<Map<String, Value>>,
) -> Option<Ingredient> {
    Some(Ingredient { name: name.into(), scene: scene?, states_lost: 0 })
}
