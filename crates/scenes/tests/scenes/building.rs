//! The building of ten storeys by each of its methods.

use scenes::RunError;
use serde_json::Value;

use crate::harness::{SceneRun, changed, numbers_in, whole_merged_and_on_ranks};

const BUILDING: &str = include_str!("../../../../tests/scenes/fpk/ten_storeys.json");
const OWN: &str = "'guided_paths': { 'samples': 20000, 'step': 0.01, 'seed': 1 }";

/// Values and errors of the first series.
fn first(result: &Value) -> Vec<(f64, f64)> {
    let values = result["quantities"][0]["values"].as_array().unwrap();
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap();
    values.iter().map(|value| (number(value, "value"), number(value, "error"))).collect()
}

#[test]
fn each_method_finds_the_same_passages_and_guided_paths_report_their_weights() {
    let by = |method: &str| {
        let changes = [
            ("[0.024, 0.029]", "[0.017]"),
            ("'until': 10, 'every': 5", "'until': 4, 'every': 2"),
            (OWN, method),
        ];
        SceneRun::of(&changed(BUILDING, &changes)).result()
    };
    let guided = by("'guided_paths': { 'samples': 2000, 'step': 0.01, 'seed': 1 }");
    let free = by("'monte_carlo': { 'paths': 20000, 'step': 0.01, 'seed': 2 }");
    let subset = by(
        "'subset_simulation': { 'samples': 200, 'correlation': 0.8, 'runs': 4, 'step': 0.01, 'seed': 3 }",
    );
    let all = [&guided, &free, &subset].map(first);
    for (t, (value, error)) in all[1].iter().enumerate().skip(1) {
        for other in [&all[0], &all[2]] {
            let (found, of_found) = other[t];
            assert!((found - value).abs() < 4.0 * error.hypot(of_found), "{all:?}");
            assert!(found > 1e-4 && of_found < 0.5 * found, "{all:?}");
        }
    }
    let weights = &guided["quantities"][0]["values"][1]["weights"];
    assert_eq!(weights["paths"], 2000);
    assert!(weights["hits"].as_u64().unwrap() > 500, "{weights}");
    assert!(weights["effective_sample_size"].as_f64().unwrap() >= 50.0, "{weights}");
    assert!(weights["largest_share"].as_f64().unwrap() <= 0.05, "{weights}");
    assert_eq!(guided["quantities"][0]["id"], "first-passage/0.017");
    assert!(free["quantities"][0]["values"][1].get("weights").is_none());
}

/// The building of ten storeys up to 2 s, for which less than a second is enough.
fn short(method: &str) -> String {
    let changes = [
        ("[0.024, 0.029]", "[0.008, 0.012]"),
        ("'until': 10, 'every': 5", "'until': 2, 'every': 1"),
        (OWN, method),
    ];
    changed(BUILDING, &changes)
}

#[test]
fn merged_shards_and_ranks_have_the_bits_of_one_run() {
    for (name, paths) in [("guided_paths", "samples"), ("monte_carlo", "paths")] {
        let by = |seed: u32| {
            short(&format!("'{name}': {{ '{paths}': 2500, 'step': 0.02, 'seed': {seed} }}"))
        };
        let whole = whole_merged_and_on_ranks(&by(1), &by(2));
        assert_eq!(whole["quantities"].as_array().unwrap().len(), 2, "{whole}");
        assert!(first(&whole)[1].0 > 1e-4, "{whole}");
    }
}

#[test]
fn an_interrupted_run_resumes_with_the_bits_of_one_run_and_subset_simulation_has_no_shards() {
    let text = short("'guided_paths': { 'samples': 2500, 'step': 0.02, 'seed': 1 }");
    let ran = SceneRun::of(&text);
    let whole = numbers_in(&ran.out());
    std::fs::remove_file(ran.out().join("result.json")).unwrap();
    // All blocks are in the checkpoint: none is computed again.
    ran.resume(&text).unwrap();
    assert_eq!(numbers_in(&ran.out()), whole);
    let error = ran.resume(&text.replace("2500", "2600")).unwrap_err().to_string();
    assert!(error.contains("is of another scene"), "{error}");
    let subset = "'subset_simulation': { 'samples': 100, 'correlation': 0.8, 'runs': 4, 'step': 0.02, 'seed': 3 }";
    ran.write(&short(subset));
    let error = ran.shard("1/2", "shard").unwrap_err();
    assert!(matches!(error, RunError::NoShards), "{error}");
}
