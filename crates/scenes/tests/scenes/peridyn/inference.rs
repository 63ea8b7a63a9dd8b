//! Inference from measured plates: a complete small run, and what resumes.

use std::fmt::Write as _;
use std::sync::LazyLock;

use peridyn_sde::statistics::CrackRecord;
use scenes::checkpoint::CheckpointError;
use scenes::peridyn::scene::CrackScene;
use scenes::peridyn::scene_problem::CrackProblem;
use scenes::scene::SceneFile;
use serde_json::Value;

use super::*;
use crate::harness::{numbers_in, on_three_ranks};
use crate::long_runs::refused_and_resumed_beside;

const INFERENCE: &str = include_str!("../../small/peridyn/inference.json");

/// The plate of the built-in scene, smaller, with two shells of neighbours and fewer steps.
const MODEL: &str = include_str!("../../small/peridyn/inference_plate.json");

/// Energy release rate of the measured plates (J/m^2).
const TRUTH: &str = "4.5";

/// Paths and failure loads of eight plates at the truth, with another seed than that of the inference.
static PLATES: LazyLock<[String; 2]> = LazyLock::new(|| {
    let text = changed(MODEL, &[("3.8", TRUTH), ("'seed': 7", "'seed': 103")]);
    let scene: CrackScene = SceneFile::from_text("plate.json", text).unwrap().parse().unwrap();
    let problem = CrackProblem::new(&scene, None).unwrap();
    let run = problem.run(&scene, 0..32).unwrap();
    let is_complete =
        |record: &&CrackRecord| record.exit.is_some() && record.failure_load.is_some();
    let records: Vec<&CrackRecord> = run.records.iter().filter(is_complete).take(8).collect();
    assert_eq!(records.len(), 8);
    let mut paths = "# Eight plates of the model itself.\nplate,x,y\n".to_owned();
    let mut loads = "plate,failure_load\n".to_owned();
    for (number, record) in records.into_iter().enumerate() {
        let name = format!("p{number}");
        for [x, y] in &record.path {
            writeln!(paths, "{name},{x},{y}").unwrap();
        }
        writeln!(loads, "{name},{}", record.failure_load.unwrap()).unwrap();
    }
    [paths, loads]
});

/// The files that the scene names.
pub(crate) fn files() -> [(&'static str, &'static str); 3] {
    let [paths, loads] = &*PLATES;
    files_with(MODEL, [paths, loads])
}

fn files_with<'a>(plate: &'a str, [paths, loads]: [&'a str; 2]) -> [(&'static str, &'a str); 3] {
    [("plate.json", plate), ("paths.csv", paths), ("loads.csv", loads)]
}

fn inferred(text: &str, files: [(&str, &str); 3]) -> SceneRun {
    SceneRun::beside(text, &files.map(|(name, text)| (name, text.as_bytes())))
}

fn run_changed(changes: &[(&str, &str)]) -> SceneRun {
    inferred(&changed(INFERENCE, changes), files())
}

#[test]
fn ensembles_that_would_take_too_long_are_refused_and_go_on_where_they_were() {
    refused_and_resumed_beside(INFERENCE, &files());
}

#[test]
fn every_number_of_a_posterior_has_its_error_and_the_truth_lies_in_it() {
    let ran = run_changed(&[]);
    let result = ran.result();
    let of = &result["parameters"][0];
    assert_eq!(of["key"], "material.toughness.energy_release_rate");
    for name in ["mean", "standard_deviation", "contraction"] {
        assert!(of[name]["error"].as_f64().unwrap() > 0.0, "{name}");
    }
    let value = |number: &Value| number["value"].as_f64().unwrap();
    let quantiles: Vec<f64> = of["quantiles"].as_array().unwrap().iter().map(value).collect();
    assert!(quantiles.windows(2).all(|pair| pair[0] < pair[1]) && quantiles.len() == 3);
    let truth: f64 = TRUTH.parse().unwrap();
    let away = (value(&of["mean"]) - truth).abs() / value(&of["standard_deviation"]);
    assert!(away < 4.0, "{away}");
    assert_eq!(of["is_identified"], true);
    assert!(of["r_hat"].as_f64().unwrap() < 1.1);
    // Densities of prior and posterior have the integral one.
    for density in ["prior", "posterior"] {
        let of_bin = |bin: &Value| {
            let width = bin["high"].as_f64().unwrap() - bin["low"].as_f64().unwrap();
            width * bin[density].as_f64().unwrap_or_else(|| value(&bin[density]))
        };
        let mass: f64 = of["marginal"].as_array().unwrap().iter().map(of_bin).sum();
        assert!((mass - 1.0).abs() < 1e-9, "{density}: {mass}");
    }
    for (pointer, n) in [("/emulator/points", 8), ("/emulator/fit", 5), ("/predictive/draws", 4)] {
        assert_eq!(result.pointer(pointer).unwrap().as_array().unwrap().len(), n, "{pointer}");
    }
    let share = &result["predictive"]["share_inside"];
    assert!(value(share) > 0.0 && share["error"].as_f64().unwrap() > 0.0);
    let of_files = result["files"].as_array().unwrap();
    let names: Vec<&str> = of_files.iter().map(|file| file["path"].as_str().unwrap()).collect();
    assert_eq!(names, ["plate.json", "paths.csv", "loads.csv"]);
    let files: Vec<_> = ran.written.iter().flatten().filter_map(|path| path.file_name()).collect();
    for file in ["predictive.svg", "posterior-1.svg", "index.html"] {
        assert!(files.contains(&std::ffi::OsStr::new(file)), "{file}");
    }
}

#[test]
fn loads_in_another_unit_are_no_identification() {
    let [paths, loads] = &*PLATES;
    let in_kilonewton: String = loads.lines().fold(String::new(), |mut all, line| {
        let (name, load) = line.split_once(',').unwrap();
        match load.parse::<f64>() {
            Ok(load) => writeln!(all, "{name},{}", 1e-3 * load).unwrap(),
            Err(_) => writeln!(all, "{line}").unwrap(),
        }
        all
    });
    let ran = inferred(INFERENCE, files_with(MODEL, [paths, &in_kilonewton]));
    let result = ran.result();
    let of = &result["parameters"][0];
    assert_eq!(of["is_identified"], false);
    assert_eq!(of["verdict"], "data outside the predictions");
    let outside: Vec<bool> = result["predictive"]["summaries"]
        .as_array()
        .unwrap()
        .iter()
        .map(|summary| summary["is_outside"].as_bool().unwrap())
        .collect();
    assert_eq!(outside, [false, true]);
}

#[test]
fn a_file_that_is_no_scene_is_not_shown() {
    let [paths, loads] = &*PLATES;
    let secret = "# a line\nuser = someone\n";
    let ran = inferred(INFERENCE, files_with(secret, [paths, loads]));
    let Err(RunError::Scene(error)) = &ran.written else { panic!("{:?}", ran.written) };
    assert_eq!(ran.mistake().path, "plate");
    assert!(!format!("{error:?}").contains("someone"), "{error:?}");
}

const KEY: &str = "material.toughness.energy_release_rate";

#[test]
fn the_horizon_is_a_parameter_where_the_plate_gives_it_as_a_length() {
    let plate = changed(MODEL, &[("{ 'shells': 2 }", "{ 'length': 0.0045 }")]);
    let changes = [
        (KEY, "bonds.horizon.length"),
        ("'low': 3, 'high': 6", "'low': 0.0042, 'high': 0.0068"),
        ("'points': 8", "'points': 7"),
    ];
    let [paths, loads] = &*PLATES;
    let result =
        inferred(&changed(INFERENCE, &changes), files_with(&plate, [paths, loads])).result();
    let mean = result["parameters"][0]["mean"]["value"].as_f64().unwrap();
    assert!((0.0042..0.0068).contains(&mean), "{mean}");
    // Two lengths are two ensembles: the horizon reaches the plate.
    let points = result["emulator"]["points"].as_array().unwrap();
    let lengths: Vec<f64> =
        points.iter().map(|point| point["point"][0].as_f64().unwrap()).collect();
    assert!(lengths.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 1e-5), "{lengths:?}");
}

#[test]
fn finished_ensembles_serve_more_points_and_other_data_bitwise() {
    let ran = run_changed(&[("'points': 8", "'points': 7")]);
    ran.result();
    let longer = [("0.01 }", "0.02 }"), ("[0.02]", "[0.018]")];
    ran.resume(&changed(INFERENCE, &longer)).unwrap();
    let undisturbed = run_changed(&longer);
    undisturbed.result();
    assert_eq!(numbers_in(&ran.out()), numbers_in(&undisturbed.out()));
    // Other realisations and another plate are other ensembles.
    let others = [
        (changed(INFERENCE, &[("'realisations': 32", "'realisations': 48")]), MODEL.to_owned()),
        (changed(INFERENCE, &longer), changed(MODEL, &[("'steps': 300", "'steps': 301")])),
    ];
    for (text, plate) in others {
        std::fs::write(ran.folder().join("plate.json"), plate).unwrap();
        let refused = ran.resume(&text);
        assert!(
            matches!(refused, Err(RunError::Checkpoint(CheckpointError::Refused(_)))),
            "{refused:?}"
        );
    }
}

#[test]
fn ranks_share_the_points_of_the_design_bitwise() {
    let ran = run_changed(&[]);
    ran.result();
    assert_eq!(numbers_in(&ran.out()), numbers_in(&on_three_ranks(&ran)));
}

#[test]
fn shards_and_ladders_are_refused_with_a_reason() {
    let ran = run_changed(&[]);
    let shard = ran.shard("1/2", "shard");
    assert!(matches!(shard, Err(RunError::NoShards)), "{shard:?}");
    let file = SceneFile::from_text("scene.json", INFERENCE.to_owned()).unwrap();
    let ladder = (scenes::kind_of(scenes::ALL, &file).unwrap().ladder)(&file);
    assert!(matches!(ladder, Err(RunError::NoLadder { solver: "peridyn-sde-inference", .. })));
}

#[test]
fn an_unknown_parameter_is_told_the_nearest_or_all() {
    for (key, expected) in [
        (
            "material.toughnes.energy_release_rate",
            "did you mean `material.toughness.energy_release_rate`?",
        ),
        ("shape.of.length", "did you mean `strength.field.correlation.length`?"),
        ("q", "its numbers are `body."),
    ] {
        let ran = run_changed(&[(KEY, key)]);
        let help = ran.mistake().help.as_deref().unwrap();
        assert!(help.starts_with(expected), "{help}");
    }
}

#[test]
fn an_error_of_the_plate_is_shown_in_its_own_file() {
    let [paths, loads] = &*PLATES;
    let plate = changed(MODEL, &[("'spacing': 0.002", "'spacing': -1")]);
    let ran = inferred(INFERENCE, files_with(&plate, [paths, loads]));
    assert_eq!(ran.mistake().path, "body.spacing");
    let Err(RunError::Scene(error)) = &ran.written else { panic!("{:?}", ran.written) };
    assert!(error.to_string().contains("plate.json line"), "{error}");
}

#[test]
fn an_error_in_measured_files_names_file_and_line() {
    let ([paths, loads], key) = (&*PLATES, "measured.paths");
    let on_loads = "measured.failure_loads";
    let twice = format!("{loads}p0,1\n");
    for (plates, path, words) in [
        (["", loads.as_str()], key, "paths.csv is empty"),
        (["plate,x\np0,1\n", loads], key, "paths.csv has no column `y`; its columns are plate, x"),
        (["plate,x,y,y\np0,1,1,1\n", loads], key, "paths.csv has the column `y` twice"),
        (["plate,x,y\n", loads], key, "paths.csv has a head and no rows"),
        (["plate,x,y\n,1,1\n", loads], key, "paths.csv line 2 has no name of a plate"),
        (["plate,x,y\n# mm\np0,9,8\n", loads], key, "line 3 lies at [9, 8], outside the body"),
        (["plate,x,y\np0,0.01,NaN\n", loads], key, "column 3 (`y`) is NaN; it must be finite"),
        (["plate,x,y\np0,0.01,0.008\n", loads], key, "the path of the plate `p0`"),
        (
            ["plate,x,y\np0,0.0096,0.016\np0,0.012,0.016\n", "plate,failure_load\np0,10\n"],
            "summaries.abscissae",
            "no plate has a crack at all abscissae",
        ),
        ([paths, "plate,failure_load\np0,-1\n"], on_loads, "line 2 has the failure load -1"),
        ([paths, "plate,failure_load\np9,10\n"], on_loads, "has the plate `p9`, which has no path"),
        ([paths, twice.as_str()], on_loads, "loads.csv line 10 has the plate `p0` a second time"),
        ([paths, "plate,failure_load\np0,10\n"], on_loads, "has a path and no failure load"),
    ] {
        let ran = inferred(INFERENCE, files_with(MODEL, plates));
        let mistake = ran.mistake();
        assert_eq!(mistake.path, path, "{}", mistake.message);
        assert!(mistake.message.contains(words), "{}", mistake.message);
    }
}
