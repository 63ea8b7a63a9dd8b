//! Ladder of schemes and precisions for a crack scene.

use scene_runs::kind::RunError;
use scene_runs::ladder::{Growth, Ladder, Method, Rung, Standing, whole};
use scene_runs::scene::SceneFile;

use crate::scene::{CrackScene, EnsembleScene, PrecisionScene};
use crate::scene_dynamics::{BreakingScene, DynamicsScene, SchemeScene};

/// Smallest number of realisations: those that run side by side in single precision. A bootstrap needs ten.
const FIRST: f64 = 16.0;

const LEFT_OUT: &str = "All trials use the spacing, the horizon and the step of the scene, so their errors are not included: change them and compare.";

/// Methods for a scene, its own first.
///
/// The others are other precisions, and for overdamped dynamics other explicit schemes at the same step.
///
/// Implicit schemes are omitted: they are for larger steps, so at the same step they could only be slower.
pub(super) fn ladder(file: &SceneFile) -> Result<Ladder, RunError> {
    let scene: CrackScene = file.parse()?;
    let own = scheme(&scene.dynamics);
    let mut schemes = vec![own];
    if own.is_some() {
        let others =
            [SchemeScene::EulerMaruyama, SchemeScene::LeimkuhlerMatthews, SchemeScene::Heun];
        let is_allowed = |scheme: &SchemeScene| {
            *scheme != SchemeScene::LeimkuhlerMatthews
                || scene.time.as_ref().is_none_or(|time| time.breaking != BreakingScene::Bridge)
        };
        schemes.extend(others.into_iter().filter(is_allowed).map(Some).filter(|s| *s != own));
    }
    let precisions: &[PrecisionScene] = match scene.ensemble.precision {
        _ if scene.is_quasi_static() => &[PrecisionScene::F64],
        PrecisionScene::F32 => &[PrecisionScene::F32, PrecisionScene::F64],
        PrecisionScene::F64 => &[PrecisionScene::F64, PrecisionScene::F32],
    };
    let each = |&scheme| precisions.iter().map(move |&precision| (scheme, precision));
    let ways = schemes.iter().flat_map(each);
    let methods = ways.map(|way| method(&scene, way)).collect();
    Ok(Ladder { methods, left_out: LEFT_OUT })
}

fn scheme_words(scheme: SchemeScene) -> String {
    match scheme {
        SchemeScene::EulerMaruyama => "Euler-Maruyama".to_owned(),
        SchemeScene::LeimkuhlerMatthews => "Leimkuhler-Matthews".to_owned(),
        SchemeScene::Heun => "Heun".to_owned(),
        SchemeScene::Theta(theta) => format!("theta {theta}"),
    }
}

const fn scheme(dynamics: &DynamicsScene) -> Option<SchemeScene> {
    match dynamics {
        DynamicsScene::Overdamped { scheme, .. } => Some(*scheme),
        DynamicsScene::Inertial { .. } | DynamicsScene::QuasiStatic { .. } => None,
    }
}

fn method(
    scene: &CrackScene,
    (scheme, precision): (Option<SchemeScene>, PrecisionScene),
) -> Method {
    let dynamics = match (&scene.dynamics, scheme) {
        (DynamicsScene::Overdamped { mobility, temperature, .. }, Some(scheme)) => {
            let (mobility, temperature) = (*mobility, *temperature);
            DynamicsScene::Overdamped { mobility, temperature, scheme }
        }
        (other, _) => other.clone(),
    };
    let lanes = match precision {
        PrecisionScene::F64 => "f64",
        PrecisionScene::F32 => "f32",
    };
    let own = if scene.is_quasi_static() { "quasi-static" } else { "BAOAB" };
    let name = scheme.map_or_else(|| own.to_owned(), scheme_words);
    let ensemble = EnsembleScene { precision, ..scene.ensemble.clone() };
    let scene = CrackScene { dynamics, ensemble, ..scene.clone() };
    let rung = move |size: f64| {
        let mut scene = scene.clone();
        let realisations = whole(size);
        scene.ensemble.realisations = realisations;
        let mut trial = scene.clone();
        trial.output.vtu.clear();
        let label = format!("{realisations} realisations");
        Rung::new((realisations as f64, label), &scene, &trial, &["dynamics", "ensemble"])
    };
    Method {
        name: format!("{name}, {lanes}"),
        growth: Growth::Samples,
        // All schemes omit the same error: that of the step.
        standing: Standing::Judge,
        first: FIRST,
        rung: Box::new(rung),
    }
}
