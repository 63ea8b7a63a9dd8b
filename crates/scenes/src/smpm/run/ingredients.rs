//! What can be left out of a scene of bodies.

use serde_json::{Map, Value, json};

use crate::models::Ingredient;
use crate::models::edit::{ingredient, with, without};

type Scene = Map<String, Value>;

/// Random parameters one by one, strengths of materials, limits of tension, the scheme where it is not the plainest.
pub(super) fn ingredients(scene: &Scene) -> Vec<Ingredient> {
    let mut all = Vec::new();
    let random = scene.get("random").and_then(Value::as_array);
    for (k, entry) in random.into_iter().flatten().enumerate() {
        let parameter = entry["parameter"].as_str().unwrap_or_default();
        all.push(ingredient(format!("the randomness of {parameter}"), certain(scene, k)));
    }
    let materials = scene.get("materials").and_then(Value::as_object);
    for name in materials.into_iter().flat_map(Map::keys) {
        for (key, words) in PARTS {
            // What is random in a part that is gone cannot stay random.
            let is_random = random.is_some_and(|all| {
                let start = format!("{name}.{key}.");
                all.iter()
                    .any(|entry| entry["parameter"].as_str().is_some_and(|p| p.starts_with(&start)))
            });
            if !is_random {
                let scene = without(scene, &format!("/materials/{name}"), key);
                all.push(ingredient(format!("{words} of {name}"), scene));
            }
        }
    }
    all.push(ingredient("smooth shape functions", scheme(scene, "shape", json!("linear"))));
    let none = json!({ "quadratic": 0, "linear": 0 });
    all.push(ingredient("bulk viscosity", scheme(scene, "viscosity", none)));
    let order = json!("stress_last");
    all.push(ingredient("the second transfer of momentum", scheme(scene, "update_order", order)));
    all.into_iter().flatten().collect()
}

const PARTS: [(&str, &str); 3] = [
    ("strength", "the strength"),
    ("damage", "the damage"),
    ("tension_limit", "the limit of tension"),
];

/// The scene with one random parameter at its mean.
fn certain(scene: &Scene, k: usize) -> Option<Scene> {
    let mut random = scene.get("random")?.as_array()?.clone();
    if random.len() < 2 {
        // Without any there is no variance to compare.
        return None;
    }
    random.remove(k);
    with(scene, "/random", Value::Array(random))
}

/// The scene with another choice in its scheme, unless that is the one it has.
fn scheme(scene: &Scene, key: &str, value: Value) -> Option<Scene> {
    let mut scheme = scene.get("scheme")?.as_object()?.clone();
    if scheme.get(key) == Some(&value) {
        return None;
    }
    scheme.insert(key.to_owned(), value);
    with(scene, "/scheme", Value::Object(scheme))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ladder::keys;
    use crate::scene::SceneFile;
    use crate::smpm::scene::SmpmScene;

    #[test]
    fn what_is_left_of_a_built_in_scene_is_a_scene() {
        let text =
            include_str!("../../../../../tests/scenes/smpm/contact_explosion.json").to_owned();
        let scene: SmpmScene = SceneFile::from_text("a", text).unwrap().parse().unwrap();
        let all = ingredients(&keys(&scene).unwrap());
        let names: Vec<&str> = all.iter().map(|ingredient| ingredient.name.as_str()).collect();
        assert!(names.contains(&"the randomness of steel.strength.a"), "{names:?}");
        assert!(names.contains(&"the limit of tension of water"), "{names:?}");
        // The strength of the steel is what is random here.
        assert!(!names.contains(&"the strength of steel"), "{names:?}");
        assert!(names.contains(&"smooth shape functions"), "{names:?}");
        for Ingredient { name, scene, .. } in all {
            let file = SceneFile::from_text(&name, Value::Object(scene).to_string()).unwrap();
            file.parse::<SmpmScene>().unwrap_or_else(|error| panic!("without {name}: {error:?}"));
        }
    }
}
