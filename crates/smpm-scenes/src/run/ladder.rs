//! Ladder of methods for mean and variance of a scene of bodies.

use result_figures::number::percent;
use scene_runs::kind::RunError;
use scene_runs::ladder::{Growth, Ladder, Method, Rung, Standing, two_digits, whole};
use scene_runs::scene::SceneFile;

use super::solve::DIFFERENCE;
use crate::method_scene::{DecisiveScene, MethodScene, MomentsScene, MultilevelScene};
use crate::reading::FEWEST_SAMPLES;
use crate::scene::SmpmScene;

/// Smallest number of samples.
const FIRST_SAMPLES: f64 = 10.0;
/// Seed of the trials.
const SEED: u64 = 20_260_101;
/// Step of a one-sided difference, in standard deviations: of first order in it.
const ONE_SIDED: f64 = 0.01;

const LEFT_OUT: &str = "All trials use the cell of the scene, so the grid error is not included: halve the cell and compare.";

/// Methods that solve a scene, its own first; a single one without random parameters.
pub(super) fn ladder(file: &SceneFile) -> Result<Ladder, RunError> {
    let scene: SmpmScene = file.parse()?;
    if scene.sweep.is_some() {
        let reason = "a sweep has no moments by which methods could be compared";
        return Err(RunError::NoLadder { solver: "smpm", reason });
    }
    let mut methods = vec![("deterministic, no variance", MethodScene::Deterministic)];
    if !(scene.random.is_empty() && scene.random_fields.is_empty()) {
        methods = vec![
            ("propagated derivatives", MethodScene::Propagated),
            ("differences of whole runs", MethodScene::FiniteDifference { step: DIFFERENCE }),
            (
                "one-sided differences of whole runs",
                MethodScene::ForwardDifference { step: ONE_SIDED },
            ),
            ("sigma points", MethodScene::SigmaPoints),
            ("derivatives at the local state", MethodScene::Frozen { as_printed: false }),
            (
                "derivatives at the local state, as printed",
                MethodScene::Frozen { as_printed: true },
            ),
            ("Monte Carlo", sampled(false)),
            ("Monte Carlo with control variate", sampled(true)),
            ("quasi-Monte Carlo", quasi_sampled(false)),
            ("quasi-Monte Carlo with control variate", quasi_sampled(true)),
        ];
        if let Some(method) = on_grids(&scene) {
            methods.push(("multilevel Monte Carlo", MethodScene::Multilevel(method)));
        }
    }
    methods.retain(|(_, method)| scene.has_for_fields(*method));
    if let Some(own) = methods.iter_mut().find(|(_, method)| is_alike(method, &scene.method)) {
        // With the scene's own step or seed.
        own.1 = scene.method;
    }
    methods.sort_by_key(|(_, method)| *method != scene.method);
    let methods = methods.into_iter().map(|(name, method)| sized(&scene, name, method)).collect();
    Ok(Ladder { methods, left_out: LEFT_OUT })
}

/// The scene by a method at one size. Trials use only the last time and write no fields.
fn rung(scene: &SmpmScene, method: MethodScene, size: (f64, String)) -> Option<Rung> {
    let scene = SmpmScene { method, ..scene.clone() };
    let last = scene.times.last().copied();
    let trial = SmpmScene { fields: false, times: last.into_iter().collect(), ..scene.clone() };
    Rung::new(size, &scene, &trial, &["method"])
}

const fn sampled(control: bool) -> MethodScene {
    MethodScene::MonteCarlo { samples: FEWEST_SAMPLES, seed: SEED, control }
}

/// Smallest number of points of a replica, and the number of replicas.
const FIRST_POINTS: u64 = 2;
const REPLICAS: u64 = 8;

const fn quasi_sampled(control: bool) -> MethodScene {
    let (points, replicas, seed) = (FIRST_POINTS, REPLICAS, SEED);
    MethodScene::QuasiMonteCarlo { points, replicas, seed, control }
}

/// Multilevel Monte Carlo with the keys of the scene, or with default values if the scene has coarser grids.
fn on_grids(scene: &SmpmScene) -> Option<MultilevelScene> {
    let responses = DecisiveScene::LastTime;
    let method = match scene.method {
        MethodScene::Multilevel(own) => own,
        _ => MultilevelScene::new(of_size(FIRST_SAMPLES), SEED),
    };
    let method = MultilevelScene { responses, moments: MomentsScene::Both, ..method };
    scene.cells(&method).ok().map(|_| method)
}

/// The relative error of a variance by so many samples of a normal distribution.
fn of_size(samples: f64) -> f64 {
    (2.0 / samples).sqrt()
}

fn is_alike(a: &MethodScene, b: &MethodScene) -> bool {
    match (a, b) {
        (
            MethodScene::MonteCarlo { control: a, .. },
            MethodScene::MonteCarlo { control: b, .. },
        )
        | (
            MethodScene::QuasiMonteCarlo { control: a, .. },
            MethodScene::QuasiMonteCarlo { control: b, .. },
        ) => a == b,
        (MethodScene::Frozen { .. }, MethodScene::Frozen { .. }) => a == b,
        _ => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}

fn sized(scene: &SmpmScene, name: &str, method: MethodScene) -> Method {
    let (growth, standing, first) = match method {
        MethodScene::MonteCarlo { .. } | MethodScene::Multilevel(_) => {
            (Growth::Samples, Standing::Judge, FIRST_SAMPLES)
        }
        MethodScene::QuasiMonteCarlo { replicas, .. } => {
            (Growth::Samples, Standing::Judge, (FIRST_POINTS * replicas) as f64)
        }
        _ => (Growth::Fixed, Standing::Judged, 1.0),
    };
    let scene = scene.clone();
    let rung = move |size: f64| {
        if let MethodScene::MonteCarlo { seed, control, .. } = method {
            let samples = whole(two_digits(size));
            let method = MethodScene::MonteCarlo { samples, seed, control };
            let size = (samples as f64, format!("{samples} samples"));
            return rung(&scene, method, size);
        }
        if let MethodScene::QuasiMonteCarlo { replicas, seed, control, .. } = method {
            let points = whole(size / replicas as f64).max(FIRST_POINTS).next_power_of_two();
            let method = MethodScene::QuasiMonteCarlo { points, replicas, seed, control };
            let label = format!("{replicas} x {points} points");
            return rung(&scene, method, ((points * replicas) as f64, label));
        }
        if let MethodScene::Multilevel(method) = method {
            let tolerance = two_digits(of_size(size));
            let most_runs = method.most_runs.max(whole(4.0 * size));
            let method = MultilevelScene { tolerance, most_runs, ..method };
            let label = format!("to {}", percent(tolerance));
            return rung(&scene, MethodScene::Multilevel(method), (2.0 / tolerance.powi(2), label));
        }
        (size <= 1.0).then(|| rung(&scene, method, (1.0, String::new())))?
    };
    Method { name: name.to_owned(), growth, standing, first, rung: Box::new(rung) }
}
