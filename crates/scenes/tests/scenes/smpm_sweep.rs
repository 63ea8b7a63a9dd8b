//! Random numbers beside constants of materials, and sweeps, on a block in free flight: its height is `v t - g t^2 / 2`.

use serde_json::Value;

use crate::harness::{SceneRun, changed};

const FLIGHT: &str = include_str!("../small/smpm/flight.json");

/// The block at 10 m/s without a sweep, by a method with random parameters.
fn varied(method: &str, random: &str) -> String {
    let mut scene: Value = serde_json::from_str(FLIGHT).unwrap();
    let keys = scene.as_object_mut().unwrap();
    keys.remove("sweep");
    let parse = |text: &str| serde_json::from_str(&text.replace('\'', "\"")).unwrap();
    keys.insert("method".to_owned(), parse(method));
    keys.insert("random".to_owned(), parse(random));
    scene.to_string()
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap()
}

const GRAVITY: &str =
    "[{ 'parameter': 'gravity[0]', 'law': 'normal', 'coefficient_of_variation': 0.1 }]";

/// The flight with random gravity, by so many runs.
fn random_flight(samples: u64) -> String {
    let method = format!(
        "'random': {GRAVITY}, 'method': {{ 'monte_carlo': {{ 'samples': {samples}, 'seed': 1, 'control': false }} }}"
    );
    changed(FLIGHT, &[("'method': 'deterministic'", &method)])
}

#[test]
fn velocities_and_sizes_vary_as_constants_do() {
    let method = "{ 'finite_difference': { 'step': 0.1 } }";
    let deviation = |parameter: &str| {
        let random = format!(
            "[{{ 'parameter': '{parameter}', 'law': 'normal', 'coefficient_of_variation': 0.05 }}]"
        );
        let ran = SceneRun::of(&varied(method, &random));
        number(&ran.result(), "/gauges/0/quantities/0/values/1/standard_deviation")
    };
    // Of the middle of the block, 0.4 long, after 1 s; exact but for roundoff of differences.
    for (parameter, expected) in [
        ("bodies[0].velocity[0]", 0.05 * 10.0),
        ("gravity[0]", 0.05 * 10.0 / 2.0),
        ("bodies[0].shape.box.to[0]", 0.05 * 0.4 / 2.0),
    ] {
        let error = (deviation(parameter) / expected - 1.0).abs();
        assert!(error < 1e-2, "{parameter}: {error:e}");
    }
}

#[test]
fn the_limit_of_a_certain_scene_is_bracketed() {
    let ran = SceneRun::of(FLIGHT);
    let result = ran.result();
    let limit = |key: &str| number(&result, &format!("/sweep/limit/{key}"));
    // 0.2 + v - 5 = 3.2, and steps that are shorter than the error of the bracket.
    assert!((limit("value") - 8.0).abs() <= limit("error"), "{}", limit("value"));
    assert!(limit("error") <= 0.08);
    assert_eq!(result["sweep"]["limit"]["error_kind"], "bound");
}

#[test]
fn the_limit_of_a_random_scene_has_its_mean_and_deviation() {
    let result = SceneRun::of(&random_flight(60)).result();
    // v = 3 + g / 2.
    for (key, expected) in [("limit", 8.0), ("deviation_of_limit", 0.5)] {
        let of = |part: &str| number(&result, &format!("/sweep/{key}/{part}"));
        let errors = (of("value") - expected).abs() / of("error");
        assert!(errors < 3.0, "{key}: {errors} of {}", of("error"));
    }
    let chances = result["sweep"]["probabilities"].as_array().unwrap();
    let at_limit = chances.iter().find(|it| (number(it, "/value") - 8.0).abs() < 1e-9).unwrap();
    assert!(number(at_limit, "/interval/0") < 0.5 && number(at_limit, "/interval/1") > 0.5);
}

#[test]
fn a_longer_sweep_has_the_runs_of_a_shorter_one() {
    let runs = |samples: u64| {
        let mut result = SceneRun::of(&random_flight(samples)).result();
        let runs: Vec<Value> = result["sweep"]["runs"].as_array_mut().unwrap().drain(..).collect();
        let first = |it: &Value| it["sample"].as_u64().is_none_or(|sample| sample < 12);
        runs.into_iter().filter(first).collect::<Vec<_>>()
    };
    assert_eq!(runs(12), runs(24));
}

#[test]
fn a_swept_size_keeps_its_particles_where_another_number_is_random() {
    let random = GRAVITY.replace("gravity[0]", "bodies[0].velocity[0]");
    let scene = changed(
        &random_flight(12),
        &[
            (GRAVITY, random.as_str()),
            ("'within': [[0], [0.4]]", "'within': [[0], [1]]"),
            (
                "'number': 'bodies[0].velocity[0]', 'from': 4, 'to': 12",
                "'number': 'bodies[0].shape.box.to[0]', 'from': 0.2, 'to': 0.8",
            ),
            ("'above': 3.2", "'above': 10.25"),
            ("'gravity': [-10.0]", "'gravity': [0.0]"),
            // No whole number of layers.
            ("'to': [0.4]", "'to': [0.43]"),
        ],
    );
    let result = SceneRun::of(&scene).result();
    let runs = result["sweep"]["runs"].as_array().unwrap();
    assert!(runs.len() > 12);
    for run in runs {
        let at = |k: usize| number(run, &format!("/outcome/{k}"));
        // The middle at first, by the heights at 0.5 s and 1 s, whatever the velocity is.
        let middle = 2.0 * at(0) - at(1);
        let size = number(run, "/value");
        assert!((middle - size / 2.0).abs() < 1e-9, "{middle} of {size}");
    }
}
