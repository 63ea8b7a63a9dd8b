//! The building of ten storeys by each of its methods, and scenes that are refused.

use scenes::checkpoint::Start;
use scenes::{ALL, SceneFile, check};
use serde_json::Value;

use crate::fpk::run_in;

const TOWER: &str = include_str!("../../../../tests/scenes/fpk/ten_storeys.json");
const OWN: &str = "\"guided_paths\": { \"samples\": 12000, \"step\": 0.01, \"seed\": 1 }";

/// The scene with some texts replaced.
fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(TOWER.to_owned(), |text, (from, to)| {
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

#[test]
fn mistakes_are_refused_at_their_keys() {
    let refused = |changes: &[(&str, &str)]| {
        let file = SceneFile::from_text("tower.json", changed(changes)).unwrap();
        let error = check(ALL, &file).unwrap_err();
        let scenes::RunError::Scene(error) = error else { panic!("{error}") };
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
