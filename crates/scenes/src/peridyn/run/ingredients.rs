//! What can be left out of a scene of cracks.

use serde_json::{Map, Value, json};

use crate::models::Ingredient;
use crate::models::edit::{ingredient, with, without};

type Scene = Map<String, Value>;

/// Random fields, holes, corrections of volume and surface, noise, double precision.
pub(super) fn ingredients(scene: &Scene) -> Vec<Ingredient> {
    let uniform = |key: &str| {
        let is_varied = scene.get(key).is_some_and(|variation| *variation != "uniform");
        is_varied.then(|| with(scene, &format!("/{key}"), json!("uniform")))?
    };
    let correction = |key: &str| {
        let is_there = scene.get("bonds")?.get(key).is_some_and(|found| *found != "none");
        is_there.then(|| with(scene, &format!("/bonds/{key}"), json!("none")))?
    };
    let all = [
        ingredient("the random strength", uniform("strength")),
        ingredient("the random stiffness", uniform("stiffness")),
        ingredient("the holes", without(scene, "/body", "holes")),
        ingredient("the correction of volume", correction("volume_correction")),
        ingredient("the correction of the surface", correction("surface_correction")),
        ingredient("the noise", cold(scene)),
        ingredient("double precision", single(scene)),
    ];
    all.into_iter().flatten().collect()
}

/// The scene at rest but for its load.
fn cold(scene: &Scene) -> Option<Scene> {
    let kind = scene.get("dynamics")?.as_object()?.keys().next()?;
    let pointer = format!("/dynamics/{kind}/temperature");
    let is_warm = scene.get("dynamics")?.get(kind)?.get("temperature")? != "zero";
    is_warm.then(|| with(scene, &pointer, json!("zero")))?
}

fn single(scene: &Scene) -> Option<Scene> {
    let is_double = scene.get("ensemble")?.get("precision")? == "f64";
    is_double.then(|| with(scene, "/ensemble/precision", json!("f32")))?
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ladder::keys;
    use crate::peridyn::scene::CrackScene;
    use crate::scene::SceneFile;

    #[test]
    fn what_is_left_of_a_built_in_scene_is_a_scene() {
        let expected: [(&str, &[&str]); 2] = [
            (
                include_str!("../../../../../tests/scenes/peridyn/plate_with_hole.json"),
                &["the random strength", "the holes", "the correction of volume"],
            ),
            (
                include_str!("../../../../../tests/scenes/peridyn/white_noise_plate.json"),
                &["the noise"],
            ),
        ];
        for (text, expected) in expected {
            let file = SceneFile::from_text("a", text.to_owned()).unwrap();
            let all = ingredients(&keys(&file.parse::<CrackScene>().unwrap()).unwrap());
            let names: Vec<&str> = all.iter().map(|ingredient| ingredient.name.as_str()).collect();
            assert_eq!(names, expected);
            for Ingredient { name, scene, .. } in &all {
                let text = Value::Object(scene.clone()).to_string();
                let file = SceneFile::from_text(name, text).unwrap();
                file.parse::<CrackScene>().unwrap_or_else(|error| panic!("{name}: {error:?}"));
            }
        }
    }
}
