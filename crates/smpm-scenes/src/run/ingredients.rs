//! Ingredients that can be left out of a scene of bodies.

use scene_runs::models::Ingredient;
use scene_runs::models::edit::{changed, ingredient, replace};

use crate::material_scene::MaterialScene;
use crate::scene::{SmpmScene, ViscosityScene};

/// Single random parameters, strength models, tension limits, and each refinement of the scheme.
pub(super) fn ingredients(scene: &SmpmScene) -> Vec<Ingredient> {
    let mut all = Vec::new();
    for (k, random) in scene.random.iter().enumerate() {
        all.push(ingredient(
            format!("the randomness of {}", random.parameter),
            changed(scene, |scene| certain(scene, k)),
        ));
    }
    for (k, field) in scene.random_fields.iter().enumerate() {
        all.push(ingredient(
            format!("the random field of {}", field.parameters.join(" and ")),
            changed(scene, |scene| {
                scene.random_fields.remove(k);
                !scene.random_fields.is_empty()
            }),
        ));
    }
    for name in scene.materials.keys() {
        for (key, words, take) in PARTS {
            // Random parameters of a removed part are removed too.
            let start = format!("{name}.{key}.");
            let fields = scene.random_fields.iter().flat_map(|field| &field.parameters);
            let mut random = scene.random.iter().map(|random| &random.parameter).chain(fields);
            if random.all(|parameter| !parameter.starts_with(&start)) {
                let scene = changed(scene, |scene| scene.materials.get_mut(name).is_some_and(take));
                all.push(ingredient(format!("{words} of {name}"), scene));
            }
        }
    }
    let without =
        |name: &str, change: fn(&mut SmpmScene) -> bool| ingredient(name, changed(scene, change));
    all.push(without("bulk viscosity", |scene| {
        let none = ViscosityScene { quadratic: 0.0, linear: 0.0 };
        replace(&mut scene.scheme.viscosity, Some(none))
    }));
    all.into_iter().flatten().collect()
}

/// Removes a part of a material; `false` if there is none.
type Take = fn(&mut MaterialScene) -> bool;

const PARTS: [(&str, &str, Take); 3] = [
    ("strength", "the strength", |material| material.strength.take().is_some()),
    ("damage", "the damage", |material| material.damage.take().is_some()),
    ("tension_limit", "the limit of tension", |material| material.tension_limit.take().is_some()),
];

/// Fixes one random parameter at its mean; without any there is no variance to compare.
fn certain(scene: &mut SmpmScene, k: usize) -> bool {
    scene.random.remove(k);
    !scene.random.is_empty()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use scene_runs::scene::SceneFile;

    #[test]
    fn what_is_left_of_a_built_in_scene_is_a_scene() {
        let text = include_str!("../../../../tests/scenes/smpm/contact_explosion.json").to_owned();
        let scene: SmpmScene = SceneFile::from_text("a", text).unwrap().parse().unwrap();
        let all = ingredients(&scene);
        let names: Vec<&str> = all.iter().map(|ingredient| ingredient.name.as_str()).collect();
        assert!(names.contains(&"the randomness of steel.strength.a"), "{names:?}");
        assert!(names.contains(&"the limit of tension of water"), "{names:?}");
        // The strength of the steel is random here.
        assert!(!names.contains(&"the strength of steel"), "{names:?}");
        assert!(names.contains(&"bulk viscosity"), "{names:?}");
        for Ingredient { name, scene, .. } in all {
            let file = SceneFile::from_text(&name, Value::Object(scene).to_string()).unwrap();
            file.parse::<SmpmScene>().unwrap_or_else(|error| panic!("without {name}: {error:?}"));
        }
    }
}
