//! Ladder of methods for a density scene.

use std::sync::Arc;

use fpk_sph::Method as FpkMethod;
use scene_runs::kind::RunError;
use scene_runs::ladder::{Growth, Ladder, Method, Rung, Standing, two_digits, whole};
use scene_runs::scene::{Scene, SceneFile};

use crate::lattice_scene::{FilterScene, LatticeScene};
use crate::law_scene::LawScene;
use crate::method_scene::{FEWEST_STEPS_PER_PERIOD, MOST_CELLS, MethodScene};
use crate::paths::PathIntegrator;
use crate::scene::{FpkScene, Times};
use crate::system::System;

/// Steps of a sampled path per period, for splittings and methods of order 1.5.
const STEPS_PER_PERIOD: f64 = 64.0;
/// The same for forward Euler.
const STEPS_OF_EULER: f64 = 1024.0;
/// Smallest number of paths.
const FIRST_PATHS: u64 = 1000;
/// Half-width in standard deviations of the lattice for a scene without one.
const REACH: f64 = 6.0;
/// Half-width of the paper's lattice, in standard deviations (section 4.1.1: 0.6 and 0.4 over 0.15 and 0.10).
const PAPERS_REACH: f64 = 4.0;
/// Seed of the trials.
const SEED: u64 = 20_260_101;

/// Methods that solve a scene, its own first.
pub(super) fn ladder(file: &SceneFile) -> Result<Ladder, RunError> {
    let (scene, system) = file.build::<FpkScene>()?;
    let scene = Arc::new(scene);
    let states = system.states().len();
    let mut methods = Vec::new();
    methods.extend(conditioned(&scene, &system));
    let own = own_lattice(&scene.method).filter(|_| !scene.method.conditions_filter());
    let lattice = own.cloned().unwrap_or_else(|| default_lattice(states));
    let by_flow_map = by_lattice(&scene, "flow-map fit", lattice.clone(), states);
    methods.push((MethodScene::FlowMapFit(lattice), by_flow_map));
    if let Some(method) = papers(&scene, states) {
        methods.push(method);
    }
    methods.extend(established(&scene, &system));
    // Its own method first, the others in their order.
    let is_own = |method: &MethodScene| {
        std::mem::discriminant(method) == std::mem::discriminant(&scene.method)
            && method.conditions_filter() == scene.method.conditions_filter()
    };
    methods.sort_by_key(|(method, _)| !is_own(method));
    let methods = methods.into_iter().map(|(_, method)| method).collect();
    Ok(Ladder { methods, left_out: LEFT_OUT })
}

const LEFT_OUT: &str = "Sampled paths are the reference for other methods; standard errors do not include the bias of the time step.";

/// The scene observed only at its last time, without pictures.
fn bare(scene: &FpkScene) -> FpkScene {
    let until = scene.times.until;
    let times = Times { until, every: until };
    FpkScene { times, planes: None, cloud: None, ..scene.clone() }
}

fn own_lattice(method: &MethodScene) -> Option<&LatticeScene> {
    if let MethodScene::FlowMapFit(lattice) = method { Some(lattice) } else { None }
}

/// The flow-map fit with the states of a filter conditioned out, where the scene asks for the structure alone.
fn conditioned(scene: &Arc<FpkScene>, system: &System) -> Option<(MethodScene, Method)> {
    let states = system.structure_states()?.len();
    // A ball: waves grow in the corners of a fine box.
    let default = || LatticeScene { count: None, spacing: Some(1.0), ..default_lattice(states) };
    let own = own_lattice(&scene.method).filter(|_| scene.method.conditions_filter());
    let mut lattice = LatticeScene {
        filter: Some(FilterScene::Conditioned),
        ..own.cloned().unwrap_or_else(default)
    };
    if scene.system.shakes_cubic_spring() {
        lattice.fresh_lattices.get_or_insert_default();
    }
    let method = MethodScene::FlowMapFit(lattice.clone());
    let asked = FpkScene { method: method.clone(), ..FpkScene::clone(scene) };
    asked.check().ok()?;
    let name = "flow-map fit, filter conditioned out";
    Some((method, by_lattice(scene, name, lattice, states)))
}

/// A box in two dimensions, where corners are cheap; a ball in higher dimensions.
fn default_lattice(states: usize) -> LatticeScene {
    let lattice = LatticeScene { reach: Some(REACH), ..Default::default() };
    if states <= 2 {
        LatticeScene { count: Some(vec![21; states]), ..lattice }
    } else {
        LatticeScene { spacing: Some(1.0), ..lattice }
    }
}

/// Smallest number of intervals along a length for which a fit has enough neighbours.
fn first_intervals(states: usize) -> f64 {
    match states {
        1 => 20.0,
        2 => 14.0,
        3 => 10.0,
        _ => 7.0,
    }
}

fn by_lattice(scene: &Arc<FpkScene>, name: &str, lattice: LatticeScene, states: usize) -> Method {
    let scene = scene.clone();
    let rung = move |intervals: f64| {
        let (lattice, size, label) = with_intervals((&lattice, states), intervals);
        of_method(&scene, size, label, MethodScene::FlowMapFit(lattice))
    };
    Method {
        name: name.to_owned(),
        growth: Growth::Lattice { dimensions: states },
        standing: Standing::Judged,
        first: first_intervals(states),
        rung: Box::new(rung),
    }
}

/// The lattice with a number of intervals along a length, as the geometric mean over its axes; returns size and label.
fn with_intervals(
    (lattice, states): (&LatticeScene, usize),
    intervals: f64,
) -> (LatticeScene, f64, String) {
    let mut lattice = lattice.clone();
    if let Some(counts) = &mut lattice.count {
        let product: f64 = counts.iter().map(|&n| n as f64 - 1.0).product();
        let scale = intervals / product.powf(1.0 / counts.len() as f64);
        for n in &mut *counts {
            *n = 1 + count((*n as f64 - 1.0) * scale);
        }
        let product: f64 = counts.iter().map(|&n| n as f64 - 1.0).product();
        let size = product.powf(1.0 / counts.len() as f64);
        let label = counts.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ");
        (lattice, size, label)
    } else {
        // The check of the scene has seen that it has a reach.
        let reach = lattice.reach_in(states).unwrap_or(REACH);
        // Two digits, as a user would write it.
        let spacing = two_digits(2.0 * reach / intervals);
        lattice.spacing = Some(spacing);
        let size = 2.0 * reach / spacing;
        (lattice, size, format!("spacing {spacing}"))
    }
}

/// The rung of a method at a size; none if no scene may have it, such as a lattice of too many particles.
fn of_method(scene: &FpkScene, size: f64, label: String, method: MethodScene) -> Option<Rung> {
    let scene = FpkScene { method, ..scene.clone() };
    scene.check().ok()?;
    Rung::new((size, label), &scene, &bare(&scene), &["method"])
}

/// A number of particles along an axis.
fn count(size: f64) -> usize {
    usize::try_from(whole(size)).unwrap_or(usize::MAX)
}

/// The method of the paper as printed, for the start it defines: two states, a Gaussian.
fn papers(scene: &Arc<FpkScene>, states: usize) -> Option<(MethodScene, Method)> {
    let LawScene::Gaussian { standard_deviation, .. } = &scene.initial else { return None };
    if states != 2 {
        return None;
    }
    let half_width: Vec<f64> = standard_deviation.iter().map(|s| PAPERS_REACH * s).collect();
    let paper = FpkMethod::CanorDenoel2013.combination();
    let fpk_sph::StepRule::Courant { number } = paper.step else { return None };
    let of = move |n: usize| MethodScene::CanorDenoel2013 {
        count: vec![n; states],
        half_width: half_width.clone(),
        courant: number,
        support_over_spacing: paper.support_over_spacing,
    };
    let (own, scene) = (of(2), scene.clone());
    let rung = move |intervals: f64| {
        let n = 1 + count(intervals);
        of_method(&scene, n as f64 - 1.0, format!("{n} x {n}"), of(n))
    };
    let method = Method {
        name: "Canor & Denoël 2013 as printed".to_owned(),
        growth: Growth::Lattice { dimensions: states },
        standing: Standing::Judged,
        first: first_intervals(states),
        rung: Box::new(rung),
    };
    Some((own, method))
}

/// Smallest number of cells of a grid along an axis, and its steps per period for each cell.
const FIRST_GRID: (usize, f64) = (28, 0.6);
/// Smallest number of guided paths.
const FIRST_GUIDED: u64 = 300;
/// Smallest number of samples of a level of subset simulation.
const FIRST_OF_LEVEL: usize = 100;

/// Sampled paths and the methods of `random-vibration` that apply to the scene: those that its check accepts. What the scene chooses
/// besides the size of its own method stays.
fn established(scene: &Arc<FpkScene>, system: &System) -> Vec<(MethodScene, Method)> {
    let (cells, per_cell) = FIRST_GRID;
    let steps_per_period = per_cell * cells as f64;
    let period = system.reference_period();
    let step = two_digits(period / STEPS_PER_PERIOD);
    let of_paths = match system.integrator() {
        PathIntegrator::EulerMaruyama => two_digits(period / STEPS_OF_EULER),
        _ => step,
    };
    let (seed, samples, correlation, runs) = (SEED, FIRST_OF_LEVEL, 0.8, 8);
    let all = [
        MethodScene::MonteCarlo { paths: FIRST_PATHS, step: of_paths, seed },
        MethodScene::ConservativeGrid { cells, reach: 8.0, steps_per_period },
        MethodScene::StatisticalLinearisation { step },
        MethodScene::GuidedPaths { samples: FIRST_GUIDED, step, seed },
        MethodScene::SubsetSimulation { samples, correlation, runs, step, seed },
    ];
    let or_own = |method: MethodScene| {
        let is_own = std::mem::discriminant(&method) == std::mem::discriminant(&scene.method);
        if is_own { scene.method.clone() } else { method }
    };
    let answers = |method: &MethodScene| {
        FpkScene { method: method.clone(), ..FpkScene::clone(scene) }.check().is_ok()
    };
    let all = all.into_iter().map(or_own).filter(answers);
    let integrator = system.integrator();
    all.map(|method| (method.clone(), of_established(scene, method, integrator))).collect()
}

fn of_established(
    scene: &Arc<FpkScene>,
    method: MethodScene,
    integrator: PathIntegrator,
) -> Method {
    let name = match method {
        MethodScene::MonteCarlo { step, .. } => {
            format!("Monte Carlo, {}, step {step} s", integrator.name())
        }
        MethodScene::ConservativeGrid { .. } => "conservative grid".to_owned(),
        MethodScene::GuidedPaths { .. } => "guided paths".to_owned(),
        MethodScene::SubsetSimulation { .. } => "subset simulation".to_owned(),
        _ => "statistical linearisation".to_owned(),
    };
    let (growth, standing, first) = match method {
        MethodScene::MonteCarlo { .. } => (Growth::Samples, Standing::Judge, FIRST_PATHS as f64),
        // Two axes and the time.
        MethodScene::ConservativeGrid { .. } => {
            (Growth::Lattice { dimensions: 3 }, Standing::Judged, FIRST_GRID.0 as f64)
        }
        MethodScene::GuidedPaths { .. } => (Growth::Samples, Standing::Judged, FIRST_GUIDED as f64),
        MethodScene::SubsetSimulation { .. } => {
            (Growth::Samples, Standing::Judged, FIRST_OF_LEVEL as f64)
        }
        _ => (Growth::Fixed, Standing::Judged, 1.0),
    };
    let scene = scene.clone();
    let rung = move |size: f64| {
        let mut method = method.clone();
        let (size, label) = match &mut method {
            MethodScene::MonteCarlo { paths, .. } => {
                *paths = whole(two_digits(size));
                (*paths as f64, format!("{paths} paths"))
            }
            MethodScene::ConservativeGrid { cells, steps_per_period, .. } => {
                let n = count(size);
                let steps = *steps_per_period * n as f64 / *cells as f64;
                (*cells, *steps_per_period) = (n, steps.max(FEWEST_STEPS_PER_PERIOD));
                (n <= MOST_CELLS).then(|| (n as f64, format!("{n} x {n}")))?
            }
            MethodScene::GuidedPaths { samples, .. } => {
                *samples = whole(two_digits(size));
                (*samples as f64, format!("{samples} paths"))
            }
            MethodScene::SubsetSimulation { samples, .. } => {
                *samples = count(two_digits(size));
                (*samples as f64, format!("{samples} paths"))
            }
            _ => (size <= 1.0).then(|| (1.0, String::new()))?,
        };
        of_method(&scene, size, label, method)
    };
    Method { name, growth, standing, first, rung: Box::new(rung) }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    #[test]
    fn sizes_are_written_as_one_would() {
        for (exact, written) in [(0.714, "0.71"), (1.26e-3, "0.0013"), (30_400.0, "30000")] {
            assert_eq!(two_digits(exact).to_string(), written);
        }
        let lattice = LatticeScene { count: Some(vec![41, 21]), ..default_lattice(2) };
        let (lattice, size, label) = with_intervals((&lattice, 2), 14.0);
        assert_eq!((lattice.count.unwrap(), label.as_str()), (vec![21, 11], "21 x 11"));
        assert!((size - 200f64.sqrt()).abs() < 1e-12);
        let (lattice, size, label) = with_intervals((&default_lattice(3), 3), 10.0);
        assert_eq!((lattice.spacing, label.as_str()), (Some(1.2), "spacing 1.2"));
        assert!((size - 10.0).abs() < 1e-12);
    }

    #[test]
    fn a_scene_is_tried_by_the_established_methods_that_answer_it_at_sizes_that_are_scenes() {
        let names = |text: &str| -> Vec<String> {
            let ladder =
                ladder(&SceneFile::from_text("scene.json", text.to_owned()).unwrap()).unwrap();
            for method in &ladder.methods {
                for size in [method.first, 3.0 * method.first] {
                    let Some(rung) = (method.rung)(size) else { continue };
                    let keys = Value::Object(rung.scene).to_string();
                    let file = SceneFile::from_text("rung.json", keys).unwrap();
                    file.parse::<FpkScene>().unwrap_or_else(|e| panic!("{}: {e:?}", method.name));
                }
            }
            ladder.methods.into_iter().map(|method| method.name).collect()
        };
        let all =
            ["conservative grid", "statistical linearisation", "guided paths", "subset simulation"];
        let answering = |text: &str| {
            let names = names(text);
            all.map(|name| names.iter().any(|other| other == name))
        };
        let damper = include_str!("../../../../tests/scenes/fpk/viscous_damper.json");
        assert_eq!(answering(damper), [true; 4]);
        let thresholds = "[0.1, 0.25, 0.5, 0.75, 1, 1.25, 1.5]";
        assert_eq!(answering(&damper.replace(thresholds, "[]")), [true, true, false, false]);
        let hysteresis = include_str!("../../../../tests/scenes/fpk/bouc_wen.json");
        assert_eq!(answering(hysteresis), [false, true, true, true]);
        // Its own method comes first, with its own parameters.
        let fit = "\"flow_map_fit\": { \"count\": [49, 49], \"reach\": 7 }";
        let own = damper.replace(fit, "\"statistical_linearisation\": { \"step\": 0.7 }");
        assert_eq!(names(&own)[0], all[1]);
        // A filter on the lattice is another method than one that is conditioned out.
        let soil = include_str!("../../../../tests/scenes/fpk/bouc_wen_kanai_tajimi.json");
        let conditioned =
            soil.replace("\"reach\": 4.5", "\"reach\": 4.5, \"filter\": \"conditioned\"");
        let asked = conditioned.replace("[\"q\", \"z\"], [\"q\", \"v\"]", "[\"q\", \"z\"]");
        assert_eq!(names(soil)[0], "flow-map fit");
        assert_eq!(names(&asked)[0], "flow-map fit, filter conditioned out");
    }
}
