//! Ladder of methods for a scene of a building, and its ingredients.

use std::sync::Arc;

use scene_runs::kind::RunError;
use scene_runs::ladder::{Growth, Ladder, Method, Rung, Standing, two_digits, whole};
use scene_runs::models::Ingredient;
use scene_runs::models::edit::{changed, ingredient, replace};
use scene_runs::scene::SceneFile;
use vibrating_systems::Window;

use crate::building::building_scene::{HysteresisScene, SoilScene};
use crate::building::method_scene::BuildingMethod;
use crate::building::scene::PassageScene;
use crate::scene::Times;

/// Smallest numbers of paths: guided, free, and of a level of subset simulation.
const FIRST: [f64; 3] = [500.0, 1000.0, 100.0];
/// Seed of the trials of other methods.
const SEED: u64 = 20_260_101;
const LEFT_OUT: &str =
    "All methods take the same steps; standard errors do not include their bias.";

/// Methods that solve a scene, its own first.
pub(super) fn ladder(file: &SceneFile) -> Result<Ladder, RunError> {
    let (scene, _) = file.build::<PassageScene>()?;
    let step = scene.method.step();
    let (samples, correlation, runs, seed) = (100, 0.8, 8, SEED);
    let mut all = vec![
        BuildingMethod::GuidedPaths { samples: 500, step, seed },
        BuildingMethod::MonteCarlo { paths: 1000, step, seed },
        BuildingMethod::SubsetSimulation { samples, correlation, runs, step, seed },
    ];
    let is_own = |method: &BuildingMethod| method.key() == scene.method.key();
    all.sort_by_key(|method| !is_own(method));
    all[0] = scene.method.clone();
    let scene = Arc::new(scene);
    let methods = all.into_iter().map(|method| by_samples(&scene, method)).collect();
    Ok(Ladder { methods, left_out: LEFT_OUT })
}

fn by_samples(scene: &Arc<PassageScene>, method: BuildingMethod) -> Method {
    let [guided, free, of_level] = FIRST;
    let (name, first, standing) = match method {
        BuildingMethod::GuidedPaths { .. } => ("guided paths", guided, Standing::Judged),
        BuildingMethod::MonteCarlo { .. } => ("Monte Carlo", free, Standing::Judge),
        BuildingMethod::SubsetSimulation { .. } => {
            ("subset simulation", of_level, Standing::Judged)
        }
    };
    let scene = scene.clone();
    let rung = move |size: f64| {
        let (mut method, n) = (method.clone(), whole(two_digits(size)));
        match &mut method {
            BuildingMethod::GuidedPaths { samples, .. } => *samples = n,
            BuildingMethod::MonteCarlo { paths, .. } => *paths = n,
            BuildingMethod::SubsetSimulation { samples, .. } => {
                *samples = usize::try_from(n).ok()?;
            }
        }
        let scene = PassageScene { method, ..PassageScene::clone(&scene) };
        let until = scene.times.until;
        let bare = PassageScene { times: Times { until, every: until }, ..scene.clone() };
        let size = (n as f64, format!("{n} paths"));
        Rung::new(size, &scene, &bare, &["method"])
    };
    let (name, growth) = (name.to_owned(), Growth::Samples);
    Method { name, growth, standing, first, rung: Box::new(rung) }
}

/// Hysteresis, soil and modulating function.
pub(super) fn ingredients(scene: &PassageScene) -> Vec<Ingredient> {
    let without = |name: &str, change: fn(&mut PassageScene) -> bool| {
        ingredient(name, changed(scene, change))
    };
    let all = [
        without("the hysteresis", |scene| {
            replace(&mut scene.building.hysteresis, HysteresisScene::None)
        }),
        without("the soil", |scene| replace(&mut scene.ground.soil, SoilScene::None)),
        without("the modulating function", |scene| {
            replace(&mut scene.ground.window, Window::Stationary)
        }),
    ];
    all.into_iter().flatten().collect()
}
