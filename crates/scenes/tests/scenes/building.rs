//! The building of ten storeys by each of its methods, and scenes that are refused.

use mpi_ensembles::ThreadRank;
use scenes::checkpoint::Start;
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, SceneFile, check, run, run_on_ranks};
use serde_json::Value;

use crate::fpk::{result_without_clock, run_in, whole_and_merged};

const BUILDING: &str = include_str!("../../../../tests/scenes/fpk/ten_storeys.json");
const OWN: &str = "\"guided_paths\": { \"samples\": 20000, \"step\": 0.01, \"seed\": 1 }";

/// The scene with some texts replaced.
fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(BUILDING.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

fn result(name: &str, text: &str) -> Value {
    let folder = std::env::temp_dir().join(format!("building-{name}-{}", std::process::id()));
    run_in(&folder, text, Start::Anew).unwrap();
    let result = std::fs::read(folder.join("result.json")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    serde_json::from_slice(&result).unwrap()
}

/// Values and errors of the first series.
fn first(result: &Value) -> Vec<(f64, f64)> {
    let values = result["quantities"][0]["values"].as_array().unwrap();
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap();
    values.iter().map(|value| (number(value, "value"), number(value, "error"))).collect()
}

#[test]
fn each_method_finds_the_same_passages_and_guided_paths_report_their_weights() {
    let common = [
        ("[0.024, 0.029]", "[0.017]"),
        ("\"until\": 10, \"every\": 5", "\"until\": 4, \"every\": 2"),
    ];
    let by = |name: &str, method: &str| {
        let mut changes = common.to_vec();
        changes.push((OWN, method));
        result(name, &changed(&changes))
    };
    let guided =
        by("guided", "\"guided_paths\": { \"samples\": 2000, \"step\": 0.01, \"seed\": 1 }");
    let free = by("free", "\"monte_carlo\": { \"paths\": 20000, \"step\": 0.01, \"seed\": 2 }");
    let subset = "\"subset_simulation\": { \"samples\": 200, \"correlation\": 0.8, \"runs\": 4, \"step\": 0.01, \"seed\": 3 }";
    let subset = by("subset", subset);
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
    changed(&[
        ("[0.024, 0.029]", "[0.008, 0.012]"),
        ("\"until\": 10, \"every\": 5", "\"until\": 2, \"every\": 1"),
        (OWN, method),
    ])
}

#[test]
fn merged_shards_and_ranks_have_the_bits_of_one_run() {
    for (name, paths) in [("guided_paths", "samples"), ("monte_carlo", "paths")] {
        let by = |seed: u32| {
            short(&format!("\"{name}\": {{ \"{paths}\": 2500, \"step\": 0.02, \"seed\": {seed} }}"))
        };
        let [whole, merged] = whole_and_merged(&format!("building-{name}"), &by(1), &by(2));
        assert_eq!(whole, merged);
        assert_eq!(whole["quantities"].as_array().unwrap().len(), 2, "{whole}");
        assert!(first(&whole)[1].0 > 1e-4, "{whole}");
        let folder = std::env::temp_dir().join(format!("building-ranks-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("scene.json");
        std::fs::write(&scene, by(1)).unwrap();
        let options = Options::new(&folder);
        std::thread::scope(|scope| {
            for rank in ThreadRank::all(3) {
                let (scene, options) = (&scene, &options);
                scope.spawn(move || {
                    run_on_ranks(ALL, scene, options, &Progress::silent(), &rank).unwrap()
                });
            }
        });
        assert_eq!(whole, result_without_clock(&folder));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

#[test]
fn an_interrupted_run_resumes_with_the_bits_of_one_run_and_subset_simulation_has_no_shards() {
    let text = short("\"guided_paths\": { \"samples\": 2500, \"step\": 0.02, \"seed\": 1 }");
    let folder = std::env::temp_dir().join(format!("building-resumed-{}", std::process::id()));
    run_in(&folder, &text, Start::Anew).unwrap();
    let whole = result_without_clock(&folder);
    std::fs::remove_file(folder.join("result.json")).unwrap();
    // All blocks are in the checkpoint: none is computed again.
    run_in(&folder, &text, Start::GoOn).unwrap();
    assert_eq!(result_without_clock(&folder), whole);
    let other = text.replace("2500", "2600");
    let error = run_in(&folder, &other, Start::GoOn).unwrap_err().to_string();
    assert!(error.contains("is of another scene"), "{error}");
    let subset = "\"subset_simulation\": { \"samples\": 100, \"correlation\": 0.8, \"runs\": 2, \"step\": 0.02, \"seed\": 3 }";
    std::fs::write(folder.join("scene.json"), short(subset)).unwrap();
    let part = EnsemblePart::Shard("1/2".parse().unwrap());
    let options = Options { part, ..Options::new(&folder) };
    let error = run(ALL, &folder.join("scene.json"), &options, &Progress::silent()).unwrap_err();
    assert!(matches!(error, RunError::NoShards), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn mistakes_are_refused_at_their_keys() {
    let refused = |changes: &[(&str, &str)]| {
        let file = SceneFile::from_text("building.json", changed(changes)).unwrap();
        let error = check(ALL, &file).unwrap_err();
        let RunError::Scene(error) = error else { panic!("{error}") };
        error.mistake().map(|mistake| mistake.message.clone()).unwrap_or_default()
    };
    for (from, to, message) in [
        (OWN, "\"importance_sampling\": { \"samples\": 100 }", "importance_sampling"),
        (OWN, "\"monte_carlo\": { \"paths\": 100, \"step\": 0.05, \"seed\": 1 }", "0.05"),
        ("\"storey\": 1", "\"storey\": 11", "from 1 to 10"),
        ("[0.024, 0.029]", "[0.029, 0.024]", "greater than the one before it"),
        ("[0.024, 0.029]", "[]", "1 to 64 thresholds"),
        ("\"modes\": [1, 2]", "\"modes\": [1, 11]", "from 1 to 10"),
        ("36e6, 36e6, 36e6", "36e6, 36e6", "`mass` has 10"),
        ("\"post_yield_ratio\": 0.3", "\"post_yield_ratio\": 3", "from 0 to 1"),
    ] {
        let found = refused(&[(from, to)]);
        assert!(found.contains(message), "{to}: {found}");
    }
}
