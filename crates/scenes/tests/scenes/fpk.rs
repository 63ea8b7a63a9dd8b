//! Output of a run, and its continuation.

use std::path::{Path, PathBuf};

use scenes::checkpoint::Start;
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, run};
use serde_json::Value;

/// A scene of a few particles and steps.
const SMALL: &str = r#"{
  "solver": "fpk-sph",
  "title": "small",
  "system": { "bouc_wen": {
    "natural_frequency": 3.14, "damping_ratio": 0.05, "hardening": 0.5, "initial_slope": 1, "beta": 0.5,
    "gamma": 0.5, "exponent": 1, "noise_intensity": 1, "window": { "single_peak": { "peak": 1, "peak_time": 2 } }
  } },
  "initial": { "gaussian": { "mean": [0, 0, 0], "standard_deviation": [0.05, 0.05, 0.05] } },
  "method": { "flow_map_fit": { "spacing": 0.8, "reach": 4 } },
  "times": { "until": 0.2, "every": 0.1 },
  "moments": [[2, 0, 0], [0, 0, 2]],
  "demand": { "state": "z" },
  "thresholds": [0.1],
  "planes": { "states": [["q", "z"]], "times": [0.2] },
  "cloud": { "every_observations": 1 }
}"#;

#[test]
fn a_run_in_three_dimensions_writes_result_pictures_and_cloud() {
    let folder = std::env::temp_dir().join(format!("fpk-scene-{}", std::process::id()));
    let written = run_in(&folder, SMALL, Start::Anew).unwrap();
    let names: Vec<String> = written
        .iter()
        .map(|path| path.strip_prefix(&folder).unwrap().display().to_string())
        .collect();
    for expected in
        ["result.json", "cloud/cloud.pvd", "moments.svg", "exceedance.svg", "plane-q-z-t0.200.svg"]
    {
        assert!(names.iter().any(|name| name == expected), "{expected} is not among {names:?}");
    }
    let cloud = std::fs::read(folder.join("cloud/cloud-0001.vtu")).unwrap();
    assert!(cloud.starts_with(b"<?xml"), "no file of VTK");
    let result: Value =
        serde_json::from_slice(&std::fs::read(folder.join("result.json")).unwrap()).unwrap();
    let quantity = result["quantities"].as_array().unwrap();
    let named = |id: &str| quantity.iter().find(|series| series["id"] == id).unwrap();
    assert_eq!(named("moment/0-0-2")["quantity"], "E[z^2]");
    assert_eq!(named("exceedance-cell/0.1")["quantity"], "P(|z| > 0.1)");
    // At the start sigma_z = 0.05; a ball of 4 sigma holds all but 1.1e-3 of the mass.
    let z = named("moment/0-0-2")["values"][0]["value"].as_f64().unwrap();
    assert!((z / 0.0025 - 1.0).abs() < 0.05, "{z}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The result in a folder, without the CPU time and the load of the machine.
pub(crate) fn result_without_clock(folder: &Path) -> Value {
    let bytes = std::fs::read(folder.join("result.json")).unwrap();
    let mut result: Value = serde_json::from_slice(&bytes).unwrap();
    result["work"]["cpu_seconds"] = Value::Null;
    result["machine"] = Value::Null;
    // A file edited between two runs changes it.
    result["commit"] = Value::Null;
    result
}

/// The result of a whole run, in a folder of its own, and that of three shards merged.
///
/// Then shards that do not belong together are refused.
pub(crate) fn whole_and_merged(name: &str, text: &str, other: &str) -> [Value; 2] {
    let folder = std::env::temp_dir().join(format!("shards-{name}-{}", std::process::id()));
    let result = result_without_clock;
    run_in(&folder, text, Start::Anew).unwrap();
    let whole = result(&folder);
    let run_part = |text: &str, part: EnsemblePart, out: &str| {
        let scene = folder.join("scene.json");
        std::fs::write(&scene, text).unwrap();
        run(ALL, &scene, &Options { part, ..Options::new(folder.join(out)) }, &Progress::silent())
            .map(|it| it.files)
    };
    let shard = |text: &str, place: &str, out: &str| {
        let place = place.parse().unwrap();
        run_part(text, EnsemblePart::Shard(place), out).unwrap().remove(0)
    };
    let files = ["1/3", "2/3", "3/3"].map(|place| shard(text, place, &place.replace('/', "-")));
    let merge = |files: &[&PathBuf]| {
        run_part(
            text,
            EnsemblePart::Merged(files.iter().map(|file| (*file).clone()).collect()),
            "merged",
        )
    };
    // In any order.
    merge(&[&files[2], &files[0], &files[1]]).unwrap();
    let merged = result(&folder.join("merged"));
    let refused = |files: &[&PathBuf]| merge(files).unwrap_err();
    let missing = refused(&[&files[0], &files[2]]).to_string();
    assert!(missing.contains("shard 2/3 is missing"), "{missing}");
    let doubled = refused(&[&files[0], &files[1], &files[1]]).to_string();
    assert!(doubled.contains("given twice"), "{doubled}");
    let half = shard(text, "1/2", "half");
    let divided = refused(&[&files[0], &half]).to_string();
    assert!(divided.contains("1/2") && divided.contains('3'), "{divided}");
    let foreign = shard(other, "2/3", "foreign");
    let foreign = refused(&[&files[0], &foreign, &files[2]]);
    assert!(matches!(foreign, RunError::Checkpoint(_)), "{foreign}");
    std::fs::remove_dir_all(&folder).unwrap();
    [whole, merged]
}

/// Runs a text in the folder.
pub(crate) fn run_in(folder: &Path, text: &str, start: Start) -> Result<Vec<PathBuf>, RunError> {
    std::fs::create_dir_all(folder).unwrap();
    let scene = folder.join("scene.json");
    std::fs::write(&scene, text).unwrap();
    let options = Options { start, ..Options::new(folder) };
    run(ALL, &scene, &options, &Progress::silent()).map(|it| it.files)
}

fn checkpoints(folder: &Path) -> Vec<Vec<u8>> {
    let files = ["checkpoint-0.bin", "checkpoint-1.bin"].map(|name| folder.join(name));
    files.iter().filter_map(|file| std::fs::read(file).ok()).collect()
}

#[test]
fn an_earlier_end_than_that_of_a_checkpoint_is_told_from_it_and_leaves_it_as_it_is() {
    let folder = std::env::temp_dir().join(format!("fpk-earlier-{}", std::process::id()));
    let planes = ",\n  \"planes\": { \"states\": [[\"q\", \"z\"]], \"times\": [0.2] }";
    let longer = SMALL.replace(planes, "");
    assert_ne!(longer, SMALL);
    run_in(&folder, &longer, Start::Anew).unwrap();
    let kept = checkpoints(&folder);
    let shorter = longer.replace("\"until\": 0.2", "\"until\": 0.1");
    run_in(&folder, &shorter, Start::GoOn).unwrap();
    assert!(checkpoints(&folder) == kept && !kept.is_empty());
    let series = std::fs::read_to_string(folder.join("cloud/cloud.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet ").count(), 1, "{series}");
    let result: Value =
        serde_json::from_slice(&std::fs::read(folder.join("result.json")).unwrap()).unwrap();
    assert_eq!(result["quantities"][0]["values"].as_array().unwrap().len(), 1);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn another_number_of_paths_than_a_checkpoint_has_is_refused_and_leaves_it_as_it_is() {
    let folder = std::env::temp_dir().join(format!("fpk-fewer-{}", std::process::id()));
    let paths = |n: u64| {
        let method = format!("\"monte_carlo\": {{ \"paths\": {n}, \"step\": 0.02, \"seed\": 1 }}");
        SMALL.replace("\"flow_map_fit\": { \"spacing\": 0.8, \"reach\": 4 }", &method)
    };
    run_in(&folder, &paths(200), Start::Anew).unwrap();
    let kept = checkpoints(&folder);
    let error = run_in(&folder, &paths(100), Start::GoOn).unwrap_err().to_string();
    assert!(error.contains("is of another scene"), "{error}");
    assert!(checkpoints(&folder) == kept && !kept.is_empty());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn times_and_steps_that_would_mislead_are_refused_before_anything_runs() {
    let paths = |step: f64| {
        let method =
            format!("\"monte_carlo\": {{ \"paths\": 200, \"step\": {step}, \"seed\": 1 }}");
        SMALL.replace("\"flow_map_fit\": { \"spacing\": 0.8, \"reach\": 4 }", &method)
    };
    for (text, path, part) in [
        (SMALL.replace("\"until\": 0.2", "\"until\": 0.25"), "times.until", "0.2 or 0.3"),
        // The period is 2 s.
        (paths(100.0), "method.monte_carlo.step", "an eighth of the shortest period"),
        (paths(1e-300), "method.monte_carlo.step", "1e-300 was given"),
        (SMALL.replace("[\"q\", \"z\"]", "[\"q\", \"q\"]"), "planes.states[0][1]", "both are `q`"),
    ] {
        let folder = std::env::temp_dir().join(format!("fpk-refused-{}", std::process::id()));
        let error = run_in(&folder, &text, Start::Anew).unwrap_err();
        let RunError::Scene(error) = error else { panic!("{error}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, path, "{mistake:?}");
        assert!(mistake.message.contains(part), "{}", mistake.message);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

/// A building with a viscous damper behind soil, whose states are conditioned out.
fn behind_soil(until: f64) -> String {
    let text = include_str!("../../../../tests/scenes/fpk/damper_kanai_tajimi.json");
    let (method, times) = (
        "\"flow_map_fit\": { \"spacing\": 0.25, \"reach\": 5.5, \"filter\": \"conditioned\" }",
        "\"until\": 4",
    );
    let planes = ",\n  \"planes\": { \"states\": [[\"q\", \"v\"]], \"times\": [4] }";
    for part in [method, times, planes] {
        assert!(text.contains(part), "{part}");
    }
    let conditioned =
        "\"flow_map_fit\": { \"spacing\": 0.5, \"reach\": 5, \"filter\": \"conditioned\" }";
    text.replace(method, conditioned)
        .replace(times, &format!("\"until\": {until}"))
        .replace(planes, "")
}

#[test]
fn a_filter_that_is_conditioned_out_leaves_the_questions_about_the_structure() {
    let folder = std::env::temp_dir().join(format!("fpk-conditioned-{}", std::process::id()));
    run_in(&folder, &behind_soil(1.0), Start::Anew).unwrap();
    // It goes on bit for bit.
    run_in(&folder, &behind_soil(2.0), Start::GoOn).unwrap();
    let values = |folder: &Path| {
        let text = std::fs::read(folder.join("result.json")).unwrap();
        let result: Value = serde_json::from_slice(&text).unwrap();
        result["quantities"].clone()
    };
    let (whole, found) = (folder.join("whole"), values(&folder));
    run_in(&whole, &behind_soil(2.0), Start::Anew).unwrap();
    assert_eq!(values(&whole), found);
    // E[q^2] at t = 2 by 4,000,000 paths of Heun's method, 0.07 %.
    let last = found[0]["values"].as_array().unwrap().last().unwrap()["value"].as_f64().unwrap();
    let error = last / 0.0111849 - 1.0;
    // A spacing of 0.5: 0.1 % seen.
    assert!(error.abs() < 0.005, "{error:e}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_cubic_spring_behind_soil_needs_fresh_lattices_and_its_run_says_so() {
    let planes = ",\n  \"planes\": { \"states\": [[\"q\", \"v\"]], \"times\": [6] }";
    let fresh = ", \"fresh_lattices\": {}";
    let text = include_str!("../../../../tests/scenes/fpk/duffing_kanai_tajimi.json");
    assert!(text.contains(fresh) && text.contains(planes));
    let text = text.replace(planes, "").replace("\"spacing\": 0.25", "\"spacing\": 0.5");
    let folder = std::env::temp_dir().join(format!("fpk-folded-{}", std::process::id()));
    let unknown = |text: &str, until: f64| {
        let text = text.replace("\"until\": 6", &format!("\"until\": {until}"));
        run_in(&folder, &text, Start::Anew).unwrap();
        let result = std::fs::read(folder.join("result.json")).unwrap();
        let result: Value = serde_json::from_slice(&result).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        result["unknown"].to_string()
    };
    let folded = "add `fresh_lattices`";
    for (text, is_on_one) in [(text.clone(), false), (text.replace(fresh, ""), true)] {
        let said = unknown(&text, 1.0);
        assert!(said.contains("one covariance"), "{said}");
        assert_eq!(said.contains(folded), is_on_one, "{said}");
    }
}

#[test]
fn questions_about_a_filter_that_is_conditioned_out_are_refused_where_they_stand() {
    let text = behind_soil(1.0);
    for (from, to, path, part) in [
        ("[2, 0, 0, 0]", "[1, 0, 1, 0]", "moments[0]", "are conditioned out"),
        (
            "\"spacing\": 0.5",
            "\"spacing\": 0.5, \"scheme\": \"lawson_adams_bashforth_2\"",
            "method.flow_map_fit.scheme",
            "runge_kutta_4",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let folder = std::env::temp_dir().join(format!("fpk-unasked-{}", std::process::id()));
        let error = run_in(&folder, &text.replacen(from, to, 1), Start::Anew).unwrap_err();
        let RunError::Scene(error) = error else { panic!("{error}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, path, "{mistake:?}");
        assert!(mistake.message.contains(part), "{}", mistake.message);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
