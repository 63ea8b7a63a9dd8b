//! Ingredients that can be left out of a crack scene.

use scene_runs::models::Ingredient;
use scene_runs::models::edit::{changed, ingredient, replace};

use crate::scene::{CrackScene, PrecisionScene};
use crate::scene_body::{SurfaceScene, VolumeScene};
use crate::scene_dynamics::{DynamicsScene, TemperatureScene};
use crate::scene_field::VariationScene;

/// Random fields, holes, volume and surface correction, noise, double precision.
pub(super) fn ingredients(scene: &CrackScene) -> Vec<Ingredient> {
    let without =
        |name: &str, change: fn(&mut CrackScene) -> bool| ingredient(name, changed(scene, change));
    let all = [
        without("the random strength", |s| replace(&mut s.strength, VariationScene::Uniform)),
        without("the random stiffness", |s| replace(&mut s.stiffness, VariationScene::Uniform)),
        without("the holes", |s| replace(&mut s.body.holes, Vec::new())),
        without("the volume correction", |s| {
            replace(&mut s.bonds.volume_correction, VolumeScene::None)
        }),
        without("the surface correction", |s| {
            replace(&mut s.bonds.surface_correction, SurfaceScene::None)
        }),
        without("the noise", |s| match &mut s.dynamics {
            DynamicsScene::Overdamped { temperature, .. }
            | DynamicsScene::Inertial { temperature, .. } => {
                replace(temperature, TemperatureScene::Zero)
            }
            DynamicsScene::QuasiStatic { .. } => false,
        }),
        without("double precision", |s| {
            !s.is_quasi_static() && replace(&mut s.ensemble.precision, PrecisionScene::F32)
        }),
    ];
    all.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use scene_runs::scene::SceneFile;

    #[test]
    fn what_is_left_of_a_built_in_scene_is_a_scene() {
        let expected: [(&str, &[&str]); 2] = [
            (
                include_str!("../../../../tests/scenes/peridyn/plate_with_hole.json"),
                &["the random strength", "the holes", "the volume correction"],
            ),
            (
                include_str!("../../../../tests/scenes/peridyn/white_noise_plate.json"),
                &["the noise"],
            ),
        ];
        for (text, expected) in expected {
            let file = SceneFile::from_text("a", text.to_owned()).unwrap();
            let all = ingredients(&file.parse().unwrap());
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
