//! The damper of section 4.1 by the methods of random-vibration, compared with its references.

use std::path::Path;

use scenes::RunError;
use serde_json::Value;

use crate::harness::{SceneRun, changed, whole_merged_and_on_ranks};

const DAMPER: &str = include_str!("../../../../tests/scenes/fpk/viscous_damper.json");
const LINEARISED: &str = "'statistical_linearisation': { 'step': 0.05 }";
const GUIDED: &str = "'guided_paths': { 'samples': 2000, 'step': 0.04, 'seed': 7 }";
const SUBSET: &str = "'subset_simulation': { 'samples': 300, 'correlation': 0.8, 'runs': 16, 'step': 0.04, 'seed': 6 }";

/// The scene by a method, only at t = 6.
fn by(method: &str, thresholds: &str) -> String {
    let changes = [
        ("'flow_map_fit': { 'count': [49, 49], 'reach': 7 }", method),
        ("'until': 10, 'every': 0.1", "'until': 6, 'every': 6"),
        ("[0.1, 0.25, 0.5, 0.75, 1, 1.25, 1.5]", thresholds),
    ];
    changed(DAMPER, &changes)
}

fn result(text: &str) -> Value {
    SceneRun::of(text).result()
}

/// Value, error and kind of a quantity at its last time.
fn last(result: &Value, id: &str) -> Option<(f64, Option<f64>, String)> {
    let all = result["quantities"].as_array()?;
    let series = all.iter().find(|series| series["id"] == id)?;
    let observed = series["values"].as_array()?.last()?;
    let kind = observed["error_kind"].as_str()?.to_owned();
    Some((observed["value"].as_f64()?, observed["error"].as_f64(), kind))
}

/// Value and error of a reference at t = 6.
fn reference(name: &str) -> (f64, f64) {
    let path = "../../tests/reference/derived/fpk/viscous_damper.json";
    let text = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let table: Value = serde_json::from_slice(&text).unwrap();
    let entry = &table["best"][name][5];
    (entry[0].as_f64().unwrap(), entry[1].as_f64().unwrap())
}

#[test]
fn a_grid_states_an_error_that_holds_its_distance_to_the_reference() {
    let method = "'conservative_grid': { 'cells': 64, 'reach': 8, 'steps_per_period': 40 }";
    let result = result(&by(method, "[1, 1.25, 9]"));
    for (id, name) in [
        ("moment/2-0", "q2"),
        ("moment/1-1", "qv"),
        ("moment/0-2", "v2"),
        ("moment/4-0", "q4"),
        ("exceedance/1", "P_abs_q_gt_1"),
        ("exceedance/1.25", "P_abs_q_gt_1.25"),
    ] {
        let ((value, error, kind), (expected, known)) =
            (last(&result, id).unwrap(), reference(name));
        let error = error.unwrap();
        assert_eq!(kind, "two_resolutions");
        // Observed: 0.3 to 1.1 of the error, because the estimate covers only the leading order.
        let off = (value - expected).abs();
        assert!(off < 1.5 * error + 2.0 * known, "{id}: {value} {expected} {error:e}");
        // The estimate is informative: the tail of 7e-7 is known to a half.
        assert!(error < 0.5 * value, "{id}: {value} {error:e}");
    }
    // Beyond the grid the value has no error estimate.
    assert_eq!(last(&result, "exceedance/9").unwrap(), (0.0, None, "unknown".to_owned()));
}

#[test]
fn linearisation_does_not_know_its_error_but_on_a_linear_system() {
    let damper = result(&by(LINEARISED, "[1]"));
    let (value, error, kind) = last(&damper, "moment/2-0").unwrap();
    let (expected, _) = reference("q2");
    // Observed by the claims: 1.03 % too small.
    assert!((value / expected - 0.9897).abs() < 1e-3, "{value} {expected}");
    assert_eq!((error, kind.as_str()), (None, "unknown"));
    assert_eq!(damper["unknown"][0]["what"], "errors of all quantities");
    // dx = -(x - 0.5) dt + 0.5 dB from N(1, 0.04): the normal distribution at t = 2.
    let linear = r#"{ "solver": "fpk-sph", "title": "Ornstein-Uhlenbeck",
        "system": { "ornstein_uhlenbeck": { "rates": [[1]], "mean": [0.5], "noise": [[0.5]] } },
        "initial": { "gaussian": { "mean": [1], "standard_deviation": [0.2] } },
        "method": { "statistical_linearisation": { "step": 0.05 } },
        "times": { "until": 2, "every": 1 }, "moments": [[1], [4]], "thresholds": [1] }"#;
    let exact = result(linear);
    let decay = (-2.0_f64).exp();
    let (mean, variance) = (0.5 + 0.5 * decay, 0.125 + (0.04 - 0.125) * decay * decay);
    let fourth = mean.powi(4) + 6.0 * mean * mean * variance + 3.0 * variance * variance;
    for (id, expected) in [("moment/1", mean), ("moment/4", fourth)] {
        let (value, error, kind) = last(&exact, id).unwrap();
        assert_eq!(kind, "two_resolutions");
        // Of the leading order: the next order adds a fraction of the step.
        let error = error.unwrap();
        assert!((value - expected).abs() < 1.2 * error && error < 1e-5, "{id}: {value} {error:e}");
    }
    assert_eq!(exact["unknown"].as_array().unwrap().len(), 0);
}

#[test]
fn a_spectral_density_is_the_intensity_over_pi() {
    // A structure of 5 rad/s and 5 % behind the filters of Clough and Penzien, stationary after a minute.
    let scene = r#"{ "solver": "fpk-sph", "title": "stationary",
        "system": { "clough_penzien": { "structure": { "linear_oscillator": {
            "natural_frequency": 5, "damping_ratio": 0.05, "noise_intensity": 0.05, "window": "stationary" } },
            "ground_frequency": 15.6, "ground_damping": 0.6, "low_cut_frequency": 1.5, "low_cut_damping": 0.6 } },
        "initial": { "stationary_filter": { "mean": [0, 0], "standard_deviation": [0.01, 0.05] } },
        "method": { "statistical_linearisation": { "step": 0.01 } },
        "times": { "until": 60, "every": 60 }, "moments": [[2, 0, 0, 0, 0, 0]], "thresholds": [0.3] }"#;
    let (value, _, _) = last(&result(scene), "moment/2-0-0-0-0-0").unwrap();
    // |1/(w_0^2 - w^2 + 2 i xi w_0 w)|^2, and the same of both filters with their numerators.
    let below = |w: f64, own: f64, damping: f64| {
        (own * own - w * w).powi(2) + (2.0 * damping * own * w).powi(2)
    };
    let density = |w: f64| {
        let soil = 15.6_f64.powi(4) + (2.0 * 0.6 * 15.6 * w).powi(2);
        0.05 / std::f64::consts::PI * soil / below(w, 15.6, 0.6) * w.powi(4)
            / below(w, 1.5, 0.6)
            / below(w, 5.0, 0.05)
    };
    // Both sides, by the midpoint rule; beyond 200 rad/s there are 1e-9 of it.
    let integral: f64 =
        (0..100_000).map(|k| 2.0 * 0.002 * density(0.002 * (f64::from(k) + 0.5))).sum();
    assert!((value / integral - 1.0).abs() < 1e-6, "{value} {integral}");
}

#[test]
fn one_probability_is_found_with_its_standard_error_and_moments_are_unknown() {
    let (expected, known) = reference("P_abs_q_gt_1.25");
    // Bias: 150 Strang steps take 2 %; a run of subset simulation the square of its coefficient of variation besides, 0.16.
    for (name, method, most, bias) in
        // The error of guided paths has the bias of their steps, as far as pairs of paths show it.
        [("guided", GUIDED, 0.06, 0.02), ("subset", SUBSET, 0.6, 0.18)]
    {
        let result = result(&by(method, "[1.25]"));
        let (value, error, kind) = last(&result, "exceedance/1.25").unwrap();
        let error = error.unwrap();
        assert_eq!(kind, "standard_error");
        assert!(error < most * expected, "{name}: {error:e}");
        let off = (value - expected).abs();
        assert!(off < 4.0 * error + 2.0 * known + bias * expected, "{name}: {value:e} {error:e}");
        assert_eq!(last(&result, "moment/2-0"), None);
        assert_eq!(result["unknown"][0]["what"], "all moments");
        assert!(result["seed"].is_u64() && result["work"]["path_steps"].as_u64().unwrap() > 0);
    }
}

#[test]
fn merged_shards_and_ranks_of_guided_paths_have_the_bits_of_one_run() {
    let by_seed = |seed: &str| {
        let times = ("'until': 6, 'every': 6", "'until': 6, 'every': 3");
        changed(&by(GUIDED, "[0.75, 1.25]"), &[("'seed': 7", seed), times])
    };
    let whole = whole_merged_and_on_ranks(&by_seed("'seed': 7"), &by_seed("'seed': 8"));
    for id in ["exceedance/0.75", "exceedance/1.25"] {
        let series = whole["quantities"].as_array().unwrap();
        let series = series.iter().find(|series| series["id"] == id).unwrap();
        assert_eq!(series["values"].as_array().unwrap().len(), 2, "{series}");
    }
}

#[test]
fn there_are_no_shards_and_a_checkpoint_of_another_method_is_refused() {
    let ran = SceneRun::of(&by("'monte_carlo': { 'paths': 100, 'step': 0.04, 'seed': 6 }", "[1]"));
    for method in [LINEARISED, SUBSET] {
        let error = ran.resume(&by(method, "[1]")).unwrap_err();
        assert!(matches!(error, RunError::Checkpoint(_)), "{error:?}");
        let error = ran.shard("1/2", "shard").unwrap_err();
        assert!(matches!(error, RunError::NoShards), "{error}");
    }
}

#[test]
fn probabilities_whose_weights_cannot_be_trusted_are_unknown_with_the_reason() {
    // 0.4 is 2.7 deviations away; at 6, which is 40, no weight is above the smallest number.
    let times = ("'until': 6, 'every': 6", "'until': 0.04, 'every': 0.04");
    let result = result(&changed(&by(GUIDED, "[0.4, 6]"), &[times]));
    assert!(last(&result, "exceedance/0.4").is_some());
    let unknown = result["unknown"].as_array().unwrap();
    assert_eq!(unknown[1]["what"], "exceedance/6 at t = 0.04");
    let reason = unknown[1]["reason"].as_str().unwrap();
    assert!(reason.contains("effective sample size of 0.000 (at least 50)"), "{reason}");
}
