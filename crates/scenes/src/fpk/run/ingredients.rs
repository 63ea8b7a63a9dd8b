//! What can be left out of a density scene.

use serde_json::{Map, Value, json};

use crate::models::Ingredient;
use crate::models::edit::{ingredient, with, without};

type Scene = Map<String, Value>;

/// Intervals along a length, at the least, of a lattice that has lost states: 21 particles across resolve a density in two and three.
const INTERVALS: f64 = 20.0;

/// States from which on the flow-map fit is quadratic by itself.
const QUADRATIC_FROM: usize = 5;

/// Dampers, hysteresis, cubic springs, filters of the noise, its window, fresh lattices, the highest terms of the fit.
pub(super) fn ingredients(scene: &Scene) -> Vec<Ingredient> {
    let all = [
        ingredient("the filter of the ground", unfiltered(scene))
            .map(|ingredient| Ingredient { states_lost: filter_states(scene), ..ingredient }),
        linear(scene),
        ingredient("the dampers", undamped_storeys(scene)),
        ingredient("the window of the noise", stationary(scene)),
        ingredient("fresh lattices", without_fresh_lattices(scene)),
        ingredient("the cubic terms of the fit", of_lower_degree(scene)),
    ];
    all.into_iter().flatten().collect()
}

/// The name of the system, and what stands under it.
fn system(scene: &Scene) -> Option<(&str, &Value)> {
    let (name, value) = scene.get("system")?.as_object()?.iter().next()?;
    Some((name, value))
}

fn filter_states(scene: &Scene) -> usize {
    match system(scene) {
        Some(("kanai_tajimi", _)) => 2,
        Some(("clough_penzien", _)) => 4,
        _ => 0,
    }
}

/// The structure alone, in white noise.
fn unfiltered(scene: &Scene) -> Option<Scene> {
    let lost = filter_states(scene);
    if lost == 0 {
        return None;
    }
    let structure = system(scene)?.1.get("structure")?.clone();
    let mut scene = without_last_states(scene, lost)?;
    scene.insert("system".to_owned(), structure);
    if let Some(initial) = scene["initial"].get("stationary_filter").cloned() {
        scene.insert("initial".to_owned(), json!({ "gaussian": initial }));
    }
    Some(scene)
}

/// The oscillator whose spring and damper are linear.
fn linear(scene: &Scene) -> Option<Ingredient> {
    let (name, system) = system(scene)?;
    let (words, structure, states_lost) = match name {
        "viscous_damper" => ("the damper", system.get("structure")?.clone(), 0),
        "duffing" => ("the cubic spring", system.get("structure")?.clone(), 0),
        "bouc_wen" => {
            let keys = ["natural_frequency", "damping_ratio", "noise_intensity", "window"];
            let kept: Option<Scene> =
                keys.iter().map(|&key| Some((key.to_owned(), system.get(key)?.clone()))).collect();
            ("the hysteresis", Value::Object(kept?), 1)
        }
        _ => return None,
    };
    let mut scene = without_last_states(scene, states_lost)?;
    scene.insert("system".to_owned(), json!({ "linear_oscillator": structure }));
    Some(Ingredient { name: words.to_owned(), scene, states_lost })
}

/// Lists by state are shorter; moments of lost states are not asked for, nor are pictures of them.
fn without_last_states(scene: &Scene, lost: usize) -> Option<Scene> {
    if lost == 0 {
        return Some(scene.clone());
    }
    let mut scene = scene.clone();
    scene.remove("planes");
    let moments = scene.get_mut("moments")?.as_array_mut()?;
    let of_kept = |powers: &Value| {
        let powers = powers.as_array()?;
        let kept = powers.len().checked_sub(lost)?;
        powers[kept..].iter().all(|power| *power == 0).then(|| json!(powers[..kept]))
    };
    *moments = moments.iter().filter_map(of_kept).collect();
    let shorten = |list: &mut Value| {
        if let Some(list) = list.as_array_mut() {
            list.truncate(list.len().saturating_sub(lost));
        }
    };
    if let Some(gaussian) = scene.get_mut("initial")?.get_mut("gaussian") {
        gaussian.as_object_mut()?.values_mut().for_each(shorten);
    }
    for method in scene.get_mut("method")?.as_object_mut()?.values_mut() {
        for key in ["count", "half_width"] {
            if let Some(list) = method.get_mut(key) {
                shorten(list);
            }
        }
        // A lattice that is fine enough for many states has too few neighbours in fewer.
        let reach = method.get("reach").and_then(Value::as_f64);
        if let (Some(reach), Some(spacing)) = (reach, method.get_mut("spacing")) {
            let finest = 2.0 * reach / INTERVALS;
            if spacing.as_f64().is_some_and(|spacing| spacing > finest) {
                *spacing = json!(finest);
            }
        }
    }
    if let Some(weights) =
        scene.get_mut("demand").and_then(|demand| demand.pointer_mut("/combination/weights"))
    {
        shorten(weights);
    }
    Some(scene)
}

fn undamped_storeys(scene: &Scene) -> Option<Scene> {
    with(scene, "/system/two_storey/damper_coefficient", json!([0, 0]))
}

/// In noise that neither rises nor falls.
fn stationary(scene: &Scene) -> Option<Scene> {
    let (name, system) = system(scene)?;
    let inside = match (name, system.get("structure").and_then(Value::as_object)) {
        ("kanai_tajimi" | "clough_penzien", Some(structure)) => {
            let (kind, structure) = structure.iter().next()?;
            let below = if structure.get("structure").is_some() { "/structure" } else { "" };
            format!("/structure/{kind}{below}")
        }
        (_, Some(_)) => "/structure".to_owned(),
        (_, None) => String::new(),
    };
    let pointer = format!("/system/{name}{inside}/window");
    let window = Value::Object(scene.clone()).pointer(&pointer)?.clone();
    (window != "stationary").then(|| with(scene, &pointer, json!("stationary")))?
}

fn without_fresh_lattices(scene: &Scene) -> Option<Scene> {
    let method = scene.get("method")?.as_object()?.keys().next()?;
    without(scene, &format!("/method/{method}"), "fresh_lattices")
}

/// The flow map fitted by quadratic polynomials, where it is by cubic ones; the log-density fit has no lower degree.
fn of_lower_degree(scene: &Scene) -> Option<Scene> {
    let n_states = scene.get("moments")?.as_array()?.first()?.as_array()?.len();
    let mut fit = scene.get("method")?.get("flow_map_fit")?.as_object()?.clone();
    if fit.contains_key("degree") || n_states >= QUADRATIC_FROM {
        return None;
    }
    fit.insert("degree".to_owned(), json!("quadratic"));
    with(scene, "/method/flow_map_fit", Value::Object(fit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fpk::scene::FpkScene;
    use crate::scene::SceneFile;

    fn names(text: &str) -> Vec<(String, usize)> {
        let scene: Scene = serde_json::from_str(text).unwrap();
        let all = ingredients(&scene);
        for Ingredient { name, scene, .. } in &all {
            // What is left is a scene.
            let text = Value::Object(scene.clone()).to_string();
            let file = SceneFile::from_text(name, text).unwrap();
            file.parse::<FpkScene>().unwrap_or_else(|error| panic!("without {name}: {error:?}"));
        }
        all.into_iter().map(|ingredient| (ingredient.name, ingredient.states_lost)).collect()
    }

    #[test]
    fn what_is_left_of_a_built_in_scene_is_a_scene() {
        let damper = names(include_str!("../../../../../tests/scenes/fpk/viscous_damper.json"));
        assert_eq!(
            damper,
            [("the damper".to_owned(), 0), ("the window of the noise".to_owned(), 0)]
        );
        let shaken =
            names(include_str!("../../../../../tests/scenes/fpk/bouc_wen_kanai_tajimi.json"));
        let expected =
            [("the filter of the ground".to_owned(), 2), ("the window of the noise".to_owned(), 0)];
        assert_eq!(shaken, expected);
        let hysteresis = names(include_str!("../../../../../tests/scenes/fpk/bouc_wen.json"));
        assert_eq!(hysteresis[0], ("the hysteresis".to_owned(), 1));
        let storeys = names(include_str!("../../../../../tests/scenes/fpk/two_storey.json"));
        assert_eq!(storeys[0], ("the dampers".to_owned(), 0));
        let duffing = names(include_str!("../../../../../tests/scenes/fpk/duffing.json"));
        let expected = ["the cubic spring", "fresh lattices", "the cubic terms of the fit"];
        assert_eq!(duffing, expected.map(|name| (name.to_owned(), 0)));
    }
}
