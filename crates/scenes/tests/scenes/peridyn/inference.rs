//! Inference from measured plates: a complete small run, what resumes, and errors one by one.

use std::fmt::Write as _;
use std::sync::LazyLock;

use mpi_ensembles::ThreadRank;
use peridyn_sde::statistics::CrackRecord;
use scenes::peridyn::scene::CrackScene;
use scenes::peridyn::scene_problem::CrackProblem;
use scenes::run_on_ranks;
use scenes::scene::SceneFile;
use serde_json::Value;

use super::*;
use crate::long_runs::refused_and_resumed_beside;

const INFERENCE: &str = r#"{
  "solver": "peridyn-sde-inference",
  "title": "Toughness of a small plate",
  "plate": "plate.json",
  "measured": { "paths": "paths.csv", "failure_loads": "loads.csv", "height_error": 1e-4, "load_error": 0.01 },
  "summaries": { "abscissae": [0.02], "load": "log_failure_load" },
  "parameters": [
    { "key": "material.toughness.energy_release_rate", "low": 3, "high": 6, "scale": "logarithmic" }
  ],
  "design": { "points": 8, "realisations": 32 },
  "sampler": { "particles": 100, "warm_up": 100, "draws": 500 },
  "predictive": { "draws": 4, "realisations": 16 },
  "seed": 5
}"#;

/// The plate of the built-in scene, smaller, with two shells of neighbours and fewer steps.
static MODEL: LazyLock<String> = LazyLock::new(|| {
    let plate = include_str!("../../../../../tests/scenes/peridyn/notched_plate_coarse.json");
    let changes = [
        ("[0.048, 0.048]", "[0.032, 0.032]"),
        ("[0, 0.024], \"tip\": [0.0144, 0.024]", "[0, 0.016], \"tip\": [0.0096, 0.016]"),
        ("\"shells\": 3", "\"shells\": 2"),
        ("\"height\": 0.006", "\"height\": 0.004"),
        ("\"protected\": 0.01", "\"protected\": 0.008"),
        ("\"over_critical_stretch\": 1", "\"over_critical_stretch\": 1.2"),
        ("\"steps\": 1000", "\"steps\": 300"),
        ("3e5", "6e5"),
    ];
    changes.into_iter().fold(plate.to_owned(), |text, (right, other)| {
        assert!(text.contains(right), "{right}");
        text.replace(right, other)
    })
});

/// Energy release rate of the measured plates (J/m^2).
const TRUTH: &str = "4.5";

/// Paths and failure loads of eight plates at the truth, with another seed than that of the inference.
static PLATES: LazyLock<[String; 2]> = LazyLock::new(|| {
    let text = MODEL.replace("3.8", TRUTH).replace("\"seed\": 7", "\"seed\": 103");
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

fn inferred(text: &str, plate: &str, paths: &str, loads: &str) -> Ran {
    let files = [("plate.json", plate), ("paths.csv", paths), ("loads.csv", loads)]
        .map(|(name, text)| (name, text.as_bytes()));
    run_beside(text, &files)
}

fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(INFERENCE.to_owned(), |text, (right, wrong)| {
        assert!(text.contains(right), "{right}");
        text.replace(right, wrong)
    })
}

fn run_changed(changes: &[(&str, &str)]) -> Ran {
    let [paths, loads] = &*PLATES;
    inferred(&changed(changes), &MODEL, paths, loads)
}

#[test]
fn ensembles_that_would_take_too_long_are_refused_and_go_on_where_they_were() {
    let [paths, loads] = &*PLATES;
    let files = [("plate.json", MODEL.as_str()), ("paths.csv", paths), ("loads.csv", loads)];
    refused_and_resumed_beside("inference", INFERENCE, &files);
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
    assert_eq!(result["emulator"]["points"].as_array().unwrap().len(), 8);
    assert_eq!(result["emulator"]["fit"].as_array().unwrap().len(), 5);
    assert_eq!(result["predictive"]["draws"].as_array().unwrap().len(), 4);
    let share = &result["predictive"]["share_inside"];
    assert!(value(share) > 0.0 && share["error"].as_f64().unwrap() > 0.0);
    let names: Vec<&str> = result["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|file| file["path"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["plate.json", "paths.csv", "loads.csv"]);
    let files: Vec<_> = ran.written.iter().flatten().filter_map(|path| path.file_name()).collect();
    for file in ["predictive.svg", "posterior-1.svg", "index.html"] {
        assert!(files.contains(&std::ffi::OsStr::new(file)), "{file}");
    }
}

#[test]
fn the_horizon_is_a_parameter_where_the_plate_gives_it_as_a_length() {
    let plate = MODEL.replace("{ \"shells\": 2 }", "{ \"length\": 0.0045 }");
    let changes = [
        (KEY, "bonds.horizon.length"),
        ("\"low\": 3, \"high\": 6", "\"low\": 0.0042, \"high\": 0.0068"),
        ("\"points\": 8", "\"points\": 7"),
    ];
    let [paths, loads] = &*PLATES;
    let ran = inferred(&changed(&changes), &plate, paths, loads);
    let result = ran.result();
    let mean = result["parameters"][0]["mean"]["value"].as_f64().unwrap();
    assert!((0.0042..0.0068).contains(&mean), "{mean}");
    // Two lengths are two ensembles: the horizon reaches the plate.
    let points = result["emulator"]["points"].as_array().unwrap();
    let lengths: Vec<f64> =
        points.iter().map(|point| point["point"][0].as_f64().unwrap()).collect();
    assert!(lengths.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 1e-5), "{lengths:?}");
}

/// The result without machine and clock.
fn numbers(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("out/result.json")).unwrap();
    let mut result: Value = serde_json::from_str(&text).unwrap();
    for (parent, key) in [("", "machine"), ("", "commit"), ("/work", "cpu_seconds")] {
        result.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key).unwrap();
    }
    result
}

#[test]
fn finished_ensembles_serve_more_points_and_other_data_bitwise() {
    let ran = run_changed(&[("\"points\": 8", "\"points\": 7")]);
    ran.result();
    let longer = changed(&[("0.01 }", "0.02 }"), ("[0.02]", "[0.018]")]);
    std::fs::write(ran.folder().join("scene.json"), &longer).unwrap();
    let options = Options { start: Start::GoOn, ..Options::new(ran.folder().join("out")) };
    ran.again(&options).unwrap();
    let [paths, loads] = &*PLATES;
    let undisturbed = inferred(&longer, &MODEL, paths, loads);
    undisturbed.result();
    assert_eq!(numbers(ran.folder()), numbers(undisturbed.folder()));
    // Other realisations and another plate are other ensembles.
    for (file, text) in [
        ("scene.json", changed(&[("\"realisations\": 32", "\"realisations\": 48")])),
        ("plate.json", MODEL.replace("\"steps\": 300", "\"steps\": 301")),
    ] {
        let before = std::fs::read(ran.folder().join(file)).unwrap();
        std::fs::write(ran.folder().join(file), text).unwrap();
        let refused = ran.again(&options);
        assert!(
            matches!(refused, Err(RunError::Checkpoint(CheckpointError::Refused(_)))),
            "{file}: {refused:?}"
        );
        std::fs::write(ran.folder().join(file), before).unwrap();
    }
}

#[test]
fn ranks_share_the_points_of_the_design_bitwise() {
    let ran = run_changed(&[]);
    ran.result();
    let shared = run_changed(&[("\"points\": 8", "\"points\": 6")]);
    assert!(shared.written.is_err());
    let scene = shared.folder().join("scene.json");
    std::fs::write(&scene, INFERENCE).unwrap();
    let options = &Options::new(shared.folder().join("out"));
    std::thread::scope(|scope| {
        for rank in ThreadRank::all(3) {
            let scene = &scene;
            scope.spawn(move || {
                run_on_ranks(ALL, scene, options, &Progress::silent(), &rank).unwrap()
            });
        }
    });
    assert_eq!(numbers(ran.folder()), numbers(shared.folder()));
}

#[test]
fn shards_and_ladders_are_refused_with_a_reason() {
    let ran = run_changed(&[]);
    let part = EnsemblePart::Shard("1/2".parse().unwrap());
    let shard = ran.again(&Options { part, ..Options::new(ran.folder().join("shard")) });
    assert!(matches!(shard, Err(RunError::NoShards)), "{shard:?}");
    let file = SceneFile::from_text("scene.json", INFERENCE.to_owned()).unwrap();
    let ladder = (scenes::kind_of(ALL, &file).unwrap().ladder)(&file);
    assert!(matches!(ladder, Err(RunError::NoLadder { solver: "peridyn-sde-inference", .. })));
}

const KEY: &str = "material.toughness.energy_release_rate";

/// Replaced text, replacement, key, part of the message, and underlined text.
const MISTAKES: [[&str; 5]; 22] = [
    ["\"plate.json\"", "\"no.json\"", "plate", "cannot read the plate no.json", "\"no.json\""],
    [
        "\"plate.json\"",
        "\"scene.json\"",
        "plate",
        "a scene of `peridyn-sde-inference`",
        "\"scene.json\"",
    ],
    [
        KEY,
        "material.toughnes.energy_release_rate",
        "parameters[0].key",
        "has no number",
        "\"material",
    ],
    [
        KEY,
        "bonds.horizon.shells",
        "parameters[0].key",
        "is a whole number",
        "\"bonds.horizon.shells\"",
    ],
    [
        KEY,
        "bonds.volume_correction",
        "parameters[0].key",
        "has no number",
        "\"bonds.volume_correction\"",
    ],
    [KEY, "ensemble.seed", "parameters[0].key", "has no number `ensemble.seed`", "\"ensemble"],
    [
        "\"low\": 3",
        "\"low\": 7",
        "parameters[0].low",
        "the bounds of material.toughness.energy_release_rate are 7 and 6",
        "7,",
    ],
    [
        "\"material.toughness.energy_release_rate\", \"low\": 3, \"high\": 6",
        "\"time.step.z\", \"low\": 0.5, \"high\": 2.5",
        "parameters[0].high",
        "plate.json refuses time.step.z = 2.5 at `time.step.z`: the step is 2.5",
        "2.5",
    ],
    [
        "\"scale\": \"logarithmic\"",
        "\"prior\": { \"normal\": { \"median\": 9, \"standard_deviation\": 1 } }",
        "parameters[0].prior.normal.median",
        "9",
        "9,",
    ],
    [
        "\"scale\": \"logarithmic\"",
        "\"prior\": { \"normal\": { \"median\": 4, \"standard_deviation\": 0 } }",
        "parameters[0].prior.normal.standard_deviation",
        "0",
        "0 }",
    ],
    ["\"points\": 8", "\"points\": 6", "design.points", "at least 7", "6"],
    ["\"points\": 8", "\"points\": 10000000", "design.points", "at most 1000000", "10000000"],
    ["\"realisations\": 32", "\"realisations\": 5", "design.realisations", "at least 6", "5"],
    ["\"draws\": 500", "\"draws\": 99", "sampler.draws", "at least 100", "99"],
    ["\"draws\": 4", "\"draws\": 3", "predictive.draws", "at least 4", "3"],
    ["[0.02]", "[0.009]", "summaries.abscissae[0]", "not ahead of the notch", "0.009"],
    ["[0.02]", "[0.02, 0.02]", "summaries.abscissae[1]", "is given twice", "0.02]"],
    [
        "\"abscissae\": [0.02], \"load\": \"log_failure_load\"",
        "",
        "summaries",
        "nothing is compared",
        "\"summaries\"",
    ],
    [
        "\"failure_loads\": \"loads.csv\",",
        "",
        "measured",
        "the key `failure_loads` is missing",
        "\"measured\"",
    ],
    ["\"load_error\": 0.01", "\"load_error\": -1", "measured.load_error", "-1", "-1"],
    ["\"paths.csv\"", "\"plate.json\"", "measured.paths", "plate.json", "\"plate.json\""],
    [
        "\"loads.csv\"",
        "\"none.csv\"",
        "measured.failure_loads",
        "cannot read none.csv",
        "\"none.csv\"",
    ],
];

fn mistake_of(name: &str, text: &str, plates: [&str; 2]) -> (String, String, usize, String) {
    let [paths, loads] = plates.map(str::as_bytes);
    let files = [("plate.json", MODEL.as_bytes()), ("paths.csv", paths), ("loads.csv", loads)];
    mistake_beside(name, text, &files)
}

#[test]
fn mistakes_of_an_inference_are_shown_where_they_stand() {
    let [paths, loads] = &*PLATES;
    for (number, [right, wrong, path, words, under]) in MISTAKES.into_iter().enumerate() {
        let text = changed(&[(right, wrong)]);
        let found = mistake_of(&format!("infer-mistake-{number}"), &text, [paths, loads]);
        assert_eq!(found.0, path, "{}", found.1);
        assert!(found.1.contains(words), "{}", found.1);
        assert!(found.3.starts_with(under), "{path}: {}", found.3);
    }
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
        let Err(RunError::Scene(error)) = &ran.written else { panic!("{:?}", ran.written) };
        let help = error.mistake().and_then(|mistake| mistake.help.clone()).unwrap();
        assert!(help.starts_with(expected), "{help}");
    }
}

#[test]
fn an_error_of_the_plate_is_shown_in_its_own_file() {
    let [paths, loads] = &*PLATES;
    let plate = MODEL.replace("\"spacing\": 0.002", "\"spacing\": -1");
    let ran = inferred(INFERENCE, &plate, paths, loads);
    let Err(RunError::Scene(error)) = &ran.written else { panic!("{:?}", ran.written) };
    assert!(error.to_string().contains("plate.json line"), "{error}");
    assert_eq!(error.mistake().unwrap().path, "body.spacing");
}

#[test]
fn an_error_in_measured_files_names_file_and_line() {
    let ([paths, loads], key) = (&*PLATES, "measured.paths");
    let on_loads = "measured.failure_loads";
    let twice = format!("{loads}p0,1\n");
    for (number, (plates, path, words)) in [
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
    ]
    .into_iter()
    .enumerate()
    {
        let found = mistake_of(&format!("infer-file-{number}"), INFERENCE, plates);
        assert_eq!(found.0, path, "{}", found.1);
        assert!(found.1.contains(words), "{}", found.1);
    }
}
