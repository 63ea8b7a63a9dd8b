//! Ingredients that can be left out of a density scene.

use scene_runs::models::Ingredient;
use scene_runs::models::edit::{changed, ingredient, replace};
use vibrating_systems::{BoucWenParameters, DuffingParameters, LinearOscillatorParameters, Window};

use super::record::Quantity;
use crate::lattice_scene::{DegreeScene, FilterScene, LatticeScene};
use crate::law_scene::LawScene;
use crate::method_scene::MethodScene;
use crate::scene::{DemandScene, FpkScene};
use crate::system_scene::{ShakenScene, SystemScene};

/// Minimum number of intervals along a length of a lattice with fewer states.
///
/// 21 particles across resolve a density in two and three dimensions.
const INTERVALS: f64 = 20.0;

/// Number of states from which the flow-map fit is quadratic by default.
const QUADRATIC_FROM: usize = 5;

/// Dampers, hysteresis, cubic springs, noise filters, modulating function, remeshing, highest terms of the fit.
pub(super) fn ingredients(scene: &FpkScene) -> Vec<Ingredient> {
    let without =
        |name: &str, change: fn(&mut FpkScene) -> bool| ingredient(name, changed(scene, change));
    let all = [
        unfiltered(scene),
        linear(scene),
        without("the dampers", undamp_storeys),
        without("the modulating function", |scene| {
            window(&mut scene.system).is_some_and(|window| replace(window, Window::Stationary))
        }),
        without("remeshing", |scene| {
            lattice(&mut scene.method)
                .is_some_and(|lattice| lattice.fresh_lattices.take().is_some())
        }),
        without("the cubic terms of the fit", lower_degree),
    ];
    all.into_iter().flatten().collect()
}

/// The structure alone, under white noise.
fn unfiltered(scene: &FpkScene) -> Option<Ingredient> {
    let (structure, states_lost) = match &scene.system {
        SystemScene::KanaiTajimi { structure, .. } => (structure, 2),
        SystemScene::CloughPenzien { structure, .. } => (structure, 4),
        _ => return None,
    };
    let renamed = renamed_moments(scene, states_lost);
    let mut scene = without_last_states(scene, states_lost);
    scene.system = match structure.clone() {
        ShakenScene::LinearOscillator(structure) => SystemScene::LinearOscillator(structure),
        ShakenScene::ViscousDamper(damper) => SystemScene::ViscousDamper(damper),
        ShakenScene::BoucWen(hysteretic) => SystemScene::BoucWen(hysteretic),
        ShakenScene::Duffing(hardening) => SystemScene::Duffing(hardening),
        ShakenScene::TwoStorey(frame) => SystemScene::TwoStorey(frame),
    };
    if let LawScene::StationaryFilter { mean, standard_deviation } = scene.initial {
        scene.initial = LawScene::Gaussian { mean, standard_deviation };
    }
    let without = ingredient("the filter of the ground", Some(scene))?;
    Some(Ingredient { renamed, ..without })
}

/// The oscillator with a linear spring and a linear damper.
fn linear(scene: &FpkScene) -> Option<Ingredient> {
    let (name, structure, states_lost) = match scene.system.clone() {
        SystemScene::ViscousDamper(damper) => ("the damper", damper.structure, 0),
        SystemScene::Duffing(hardening) => ("the cubic spring", hardening.structure, 0),
        SystemScene::BoucWen(hysteretic) => {
            let BoucWenParameters {
                natural_frequency, damping_ratio, noise_intensity, window, ..
            } = hysteretic;
            let structure = LinearOscillatorParameters {
                natural_frequency,
                damping_ratio,
                noise_intensity,
                window,
            };
            ("the hysteresis", structure, 1)
        }
        _ => return None,
    };
    let renamed = renamed_moments(scene, states_lost);
    let scene = without_last_states(scene, states_lost);
    let scene = FpkScene { system: SystemScene::LinearOscillator(structure), ..scene };
    Some(Ingredient { renamed, ..ingredient(name, Some(scene))? })
}

/// Powers of a moment without those of the last states; none for a moment of these states.
fn without_last_powers(powers: &[u32], lost: usize) -> Option<Vec<u32>> {
    let (kept, lost) = powers.split_at(powers.len().checked_sub(lost)?);
    lost.iter().all(|&power| power == 0).then(|| kept.to_vec())
}

/// Ids of the moments of a scene, each with its id without the last states.
fn renamed_moments(scene: &FpkScene, lost: usize) -> Vec<(String, Option<String>)> {
    let id = |powers: &[u32]| Quantity::Moment(powers.to_vec()).to_string();
    let moments = scene.moments.iter().filter(|_| lost > 0);
    moments.map(|it| (id(it), without_last_powers(it, lost).map(|kept| id(&kept)))).collect()
}

/// Removes the last states: lists become shorter, and moments and pictures of the removed states are dropped.
fn without_last_states(scene: &FpkScene, lost: usize) -> FpkScene {
    let mut scene = scene.clone();
    if lost == 0 {
        return scene;
    }
    scene.planes = None;
    let kept = scene.moments.iter().filter_map(|powers| without_last_powers(powers, lost));
    scene.moments = kept.collect();
    if let LawScene::Gaussian { mean, standard_deviation } = &mut scene.initial {
        shorten(mean, lost);
        shorten(standard_deviation, lost);
    }
    if let MethodScene::CanorDenoel2013 { count, half_width, .. } = &mut scene.method {
        shorten(count, lost);
        shorten(half_width, lost);
    }
    let states =
        scene.system.build().map_or(0, |system| system.states().len()).saturating_sub(lost);
    if let Some(lattice) = lattice(&mut scene.method) {
        // A filter that was conditioned out has no axis.
        let had_axes = lattice.filter.take() != Some(FilterScene::Conditioned);
        if let Some(count) = &mut lattice.count
            && had_axes
        {
            shorten(count, lost);
        }
        let reach = lattice.reach_in(states);
        if let (Some(spacing), Some(reach)) = (&mut lattice.spacing, reach) {
            // A lattice that suffices for many states has too few neighbours in fewer dimensions.
            *spacing = spacing.min(2.0 * reach / INTERVALS);
        }
    }
    if let Some(DemandScene::Combination { weights, .. }) = &mut scene.demand {
        shorten(weights, lost);
    }
    scene
}

fn shorten<T>(list: &mut Vec<T>, lost: usize) {
    list.truncate(list.len().saturating_sub(lost));
}

fn undamp_storeys(scene: &mut FpkScene) -> bool {
    let SystemScene::TwoStorey(frame) = &mut scene.system else { return false };
    replace(&mut frame.damper_coefficient, [0.0; 2])
}

/// Modulating function of the noise or of the ground motion, if the system has one.
fn window(system: &mut SystemScene) -> Option<&mut Window> {
    Some(match system {
        SystemScene::LinearOscillator(structure)
        | SystemScene::Duffing(DuffingParameters { structure, .. }) => &mut structure.window,
        SystemScene::ViscousDamper(damper) => &mut damper.structure.window,
        SystemScene::BoucWen(hysteretic) => &mut hysteretic.window,
        SystemScene::VanDerPol { window, .. } => window,
        SystemScene::TwoStorey(frame) => &mut frame.window,
        SystemScene::KanaiTajimi { structure, .. }
        | SystemScene::CloughPenzien { structure, .. } => match structure {
            ShakenScene::LinearOscillator(structure) => &mut structure.window,
            ShakenScene::ViscousDamper(damper) => &mut damper.structure.window,
            ShakenScene::BoucWen(hysteretic) => &mut hysteretic.window,
            ShakenScene::Duffing(hardening) => &mut hardening.structure.window,
            ShakenScene::TwoStorey(frame) => &mut frame.window,
        },
        SystemScene::OrnsteinUhlenbeck { .. }
        | SystemScene::Bistable { .. }
        | SystemScene::CoxIngersollRoss { .. }
        | SystemScene::GeometricBrownianMotion { .. } => return None,
    })
}

fn lattice(method: &mut MethodScene) -> Option<&mut LatticeScene> {
    match method {
        MethodScene::FlowMapFit(lattice) => Some(lattice),
        _ => None,
    }
}

/// Replaces cubic by quadratic polynomials in the flow-map fit.
fn lower_degree(scene: &mut FpkScene) -> bool {
    let is_cubic = scene.moments.first().is_some_and(|powers| powers.len() < QUADRATIC_FROM);
    match &mut scene.method {
        MethodScene::FlowMapFit(lattice) if lattice.degree.is_none() && is_cubic => {
            lattice.degree = Some(DegreeScene::Quadratic);
            true
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use scene_runs::scene::SceneFile;

    /// Names of the ingredients, each with its number of renamed moments.
    fn names(text: &str) -> Vec<(String, usize)> {
        let scene: FpkScene = serde_json::from_str(text).unwrap();
        let all = ingredients(&scene);
        for Ingredient { name, scene, .. } in &all {
            // The remainder is a valid scene.
            let text = Value::Object(scene.clone()).to_string();
            let file = SceneFile::from_text(name, text).unwrap();
            file.parse::<FpkScene>().unwrap_or_else(|error| panic!("without {name}: {error:?}"));
        }
        all.into_iter().map(|it| (it.name, it.renamed.len())).collect()
    }

    #[test]
    fn a_moment_has_another_id_without_a_state_and_one_of_that_state_is_lost() {
        let text = include_str!("../../../../tests/scenes/fpk/bouc_wen.json");
        let scene: FpkScene = serde_json::from_str(text).unwrap();
        let renamed = renamed_moments(&scene, 1);
        assert_eq!(renamed[1], ("moment/1-1-0".to_owned(), Some("moment/1-1".to_owned())));
        assert_eq!(renamed[3], ("moment/0-0-2".to_owned(), None));
    }

    #[test]
    fn what_is_left_of_a_built_in_scene_is_a_scene() {
        let damper = names(include_str!("../../../../tests/scenes/fpk/viscous_damper.json"));
        assert_eq!(
            damper,
            [
                ("the damper".to_owned(), 0),
                ("the modulating function".to_owned(), 0),
                ("the cubic terms of the fit".to_owned(), 0)
            ]
        );
        let shaken = names(include_str!("../../../../tests/scenes/fpk/bouc_wen_kanai_tajimi.json"));
        let expected =
            [("the filter of the ground".to_owned(), 4), ("the modulating function".to_owned(), 0)];
        assert_eq!(shaken, expected);
        let hysteresis = names(include_str!("../../../../tests/scenes/fpk/bouc_wen.json"));
        assert_eq!(hysteresis[0], ("the hysteresis".to_owned(), 7));
        let storeys = names(include_str!("../../../../tests/scenes/fpk/two_storey.json"));
        assert_eq!(storeys[0], ("the dampers".to_owned(), 0));
        let duffing = names(include_str!("../../../../tests/scenes/fpk/duffing.json"));
        let expected = ["the cubic spring", "remeshing", "the cubic terms of the fit"];
        assert_eq!(duffing, expected.map(|name| (name.to_owned(), 0)));
    }
}
