//! Ladder of schemes and precisions for a crack scene.

use serde::Serialize;
use serde_json::Value;

use crate::kind::RunError;
use crate::ladder::{Growth, Ladder, Method, Quantity, Rung, Standing, whole};
use crate::peridyn::scene::{CrackScene, EnsembleScene, PrecisionScene};
use crate::peridyn::scene_dynamics::{BreakingScene, DynamicsScene, SchemeScene};
use crate::scene::SceneFile;

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

/// Keys that set a method and its size.
#[derive(Serialize)]
struct Choice<'a> {
    dynamics: &'a DynamicsScene,
    ensemble: &'a EnsembleScene,
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
        let choice = Choice { dynamics: &scene.dynamics, ensemble: &scene.ensemble };
        let label = format!("{realisations} realisations");
        Rung::new((realisations as f64, label), &scene, &trial, &choice)
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

/// Means and standard deviations of failure load, exit and length.
pub(super) fn quantities(result: &Value) -> Vec<Quantity> {
    let laws = [
        ("failure_load", "failure load"),
        ("exit", "height of exit"),
        ("length", "length of the crack"),
    ];
    laws.iter().flat_map(|(key, words)| law(key, words, &result[key])).collect()
}

fn law(id: &str, words: &str, law: &Value) -> Vec<Quantity> {
    let mut all = Vec::new();
    let quantity = |name: &str, value: f64, error: Option<f64>| Quantity {
        id: format!("{id}/{name}"),
        words: format!("{} of the {words}", name.replace('_', " ")),
        value,
        error,
        scale: value.abs(),
    };
    if let Some(mean) = law["mean"]["value"].as_f64() {
        all.push(quantity("mean", mean, law["mean"]["error"].as_f64().map(|error| 2.0 * error)));
    }
    let deviation = &law["standard_deviation"];
    let ends = (deviation["low"].as_f64(), deviation["high"].as_f64());
    if let (Some(value), (Some(low), Some(high))) = (deviation["value"].as_f64(), ends) {
        // A 95 % interval extends two standard errors to each side.
        all.push(quantity("standard_deviation", value, Some(0.5 * (high - low))));
    }
    all
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn means_tell_two_standard_errors_and_spreads_half_their_interval() {
        let deviation = json!({ "value": 0.5, "low": 0.4, "high": 0.7 });
        let result = json!({ "failure_load": {
            "mean": { "value": 10.0, "error": 0.1 }, "standard_deviation": deviation } });
        let found = quantities(&result);
        assert_eq!((found[0].id.as_str(), found[0].error), ("failure_load/mean", Some(0.2)));
        assert!((found[1].error.unwrap() - 0.15).abs() < 1e-12);
        assert_eq!(found.len(), 2);
    }
}
