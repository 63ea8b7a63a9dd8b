//! A complete run of a small scene, and its errors one by one.

mod inference;
mod points;
mod slow;

use std::path::{Path, PathBuf};

use scenes::checkpoint::{CheckpointError, Start};
use scenes::scene::SceneError;
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, run};
use tempfile::TempDir;

/// A plate of 16 by 16 nodes with a field of strength and a little noise.
const PLATE: &str = r#"{
  "solver": "peridyn-sde",
  "title": "Small plate",
  "body": { "size": [0.016, 0.016], "spacing": 0.001, "condition": { "plane_stress": { "thickness": 0.001 } } },
  "material": { "young_modulus": 72e9, "density": 2440, "toughness": { "energy_release_rate": 3.8 } },
  "bonds": { "horizon": { "shells": 2 }, "volume_correction": "ramp" },
  "notch": { "mouth": [0, 0.008], "tip": [0.006, 0.008] },
  "grips": { "height": 0.002, "hold": "clamped" },
  "loading": { "stretch": { "strain": { "over_critical_stretch": 0.8 } } },
  "dynamics": {
    "overdamped": {
      "mobility": { "identity": { "value": 1 } },
      "temperature": { "ratio": 20 },
      "scheme": "leimkuhler_matthews"
    }
  },
  "time": { "step": { "z": 0.9 }, "steps": 400 },
  "strength": {
    "field": {
      "marginal": { "lognormal": { "coefficient_of_variation": 0.1 } },
      "correlation": { "function": "matern32", "length": 0.006 }
    }
  },
  "ensemble": { "realisations": 12, "seed": 3, "precision": "f64" },
  "output": { "vtu": [0, 11], "windows": 10 }
}"#;

struct Ran {
    folder: TempDir,
    written: Result<Vec<PathBuf>, RunError>,
}

impl Ran {
    fn result(&self) -> serde_json::Value {
        let written = self.written.as_ref().unwrap();
        assert!(written.iter().all(|path| path.exists()), "{written:?}");
        let text = std::fs::read_to_string(&written[0]).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    /// Runs the current scene in the folder again.
    fn again(&self, options: &Options) -> Result<Vec<PathBuf>, RunError> {
        run(ALL, &self.folder().join("scene.json"), options, &Progress::silent()).map(|it| it.files)
    }

    fn folder(&self) -> &Path {
        self.folder.path()
    }
}

fn run_text(text: &str) -> Ran {
    run_beside(text, &[])
}

/// Runs a text with files in the same folder.
fn run_beside(text: &str, files: &[(&str, &[u8])]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    std::fs::write(&scene, text).unwrap();
    for (file, bytes) in files {
        std::fs::write(folder.path().join(file), bytes).unwrap();
    }
    let written = run(ALL, &scene, &Options::new(folder.path().join("out")), &Progress::silent());
    Ran { folder, written: written.map(|it| it.files) }
}

fn with(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(PLATE.to_owned(), |text, (right, wrong)| {
        assert!(text.contains(right), "{right}");
        text.replace(right, wrong)
    })
}

#[test]
fn a_scene_tells_its_resolved_inputs_and_every_number_with_its_error() {
    let ran = run_text(PLATE);
    let result = ran.result();
    let resolved = |key: &str| result["resolved"][key].as_f64().unwrap();
    assert_eq!((resolved("nodes"), resolved("z")), (256.0, 0.9));
    // sqrt(4 pi G0/(9 E delta)) of plane stress.
    let stretch = (4.0 * std::f64::consts::PI * 3.8 / (9.0 * 72e9 * 2.015e-3)).sqrt();
    assert!((resolved("critical_stretch") / stretch - 1.0).abs() < 1e-12);
    assert!((resolved("final_strain") / (0.8 * stretch) - 1.0).abs() < 1e-12);
    assert!((resolved("noise_ratio") - 20.0).abs() < 1e-12);
    let outcomes = result["outcomes"].as_array().unwrap();
    let of = |outcome: &serde_json::Value| outcome["probability"]["value"].as_f64().unwrap();
    // Each probability is a multiple of one twelfth.
    assert!((outcomes.iter().map(of).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(result["realisations"].as_array().unwrap().len(), 12);
    assert_eq!(result["load"].as_array().unwrap().len(), 10);
    let load = &result["load"][0]["load"];
    assert!(load["value"].as_f64().unwrap() > 0.0);
    assert_eq!(load["error_kind"], "standard_error");
    assert_eq!(result["work"]["bond_steps"], resolved("bonds") * 400.0 * 12.0);
    let files: Vec<_> = ran.written.iter().flatten().filter_map(|path| path.file_name()).collect();
    for file in ["paths.svg", "load.svg", "realisation-0000.vtu", "realisation-0011.vtu"] {
        assert!(files.contains(&std::ffi::OsStr::new(file)), "{file}");
    }
}

#[test]
fn every_dynamics_mobility_and_strength_runs() {
    let identity = "\"identity\": { \"value\": 1 }";
    let correlation = "\"correlation\": { \"function\": \"gaussian\", \"length\": 0.002 }";
    let dense = format!("\"dense\": {{ \"value\": 2, {correlation}, \"nugget\": 0.1 }}");
    let low_rank = format!(
        "\"low_rank\": {{ \"value\": 2, {correlation}, \"nugget\": 0.1, \"tolerance\": 1e-3 }}"
    );
    let lognormal = "\"lognormal\": { \"coefficient_of_variation\": 0.1 }";
    let overdamped = PLATE.split("\"dynamics\": ").nth(1).unwrap().split(",\n  \"time\"").next();
    let inertial = "{ \"inertial\": { \"friction\": 1e6, \"temperature\": { \"joule\": 1e-12 } } }";
    let field =
        PLATE.split("\"strength\": ").nth(1).unwrap().split(",\n  \"ensemble\"").next().unwrap();
    let stiffness = format!("\"strength\": \"uniform\", \"stiffness\": {field}");
    let strength = format!("\"strength\": {field}");
    let cases: [&[(&str, &str)]; 9] = [
        &[(&strength, &stiffness), ("\"clamped\"", "\"clamped\", \"protected\": 0.004")],
        &[(identity, &dense)],
        &[(identity, &low_rank), ("\"f64\"", "\"f32\"")],
        &[(overdamped.unwrap(), inertial)],
        &[
            ("\"leimkuhler_matthews\"", "\"heun\""),
            ("\"steps\": 400", "\"steps\": 400, \"breaking\": \"bridge\""),
        ],
        &[("\"leimkuhler_matthews\"", "{ \"theta\": 0.5 }"), ("0.9", "3")],
        &[(field, "\"uniform\"")],
        &[
            (lognormal, "\"weibull\": { \"shape\": 8 }"),
            ("{ \"shells\": 2 }", "{ \"length\": 0.0021 }"),
        ],
        &[
            (lognormal, "\"normal\": { \"coefficient_of_variation\": 0.1 }"),
            ("\"clamped\"", "\"sliding\""),
        ],
    ];
    for changes in cases {
        let ran = run_text(&with(changes));
        let result = ran.result();
        let broken = result["broken_bonds"]["value"].as_f64().unwrap();
        assert!(broken.is_finite() && result["failures"].as_array().unwrap().is_empty());
    }
}

#[test]
fn a_velocity_of_the_grips_is_a_strain_at_the_end() {
    let stretch = "\"stretch\": { \"strain\": { \"over_critical_stretch\": 0.8 } }";
    let velocity = "\"velocity\": { \"speed\": 1e-3 }";
    let changes =
        [(stretch, velocity), ("\"z\": 0.9", "\"dt\": 1e-9"), ("\"value\": 1 ", "\"value\": 2 ")];
    let ran = run_text(&with(&changes));
    let strain = ran.result()["resolved"]["final_strain"].as_f64().unwrap();
    // Both edges, 400 steps, over 16 mm.
    assert!((strain / (2.0 * 1e-3 * 400e-9 / 0.016) - 1.0).abs() < 1e-12, "{strain}");
}

/// The error for an invalid text.
fn mistake(name: &str, text: &str) -> (String, String, usize, String) {
    mistake_beside(name, text, &[])
}

fn mistake_beside(
    name: &str,
    text: &str,
    files: &[(&str, &[u8])],
) -> (String, String, usize, String) {
    let ran = run_beside(text, files);
    let Err(RunError::Scene(SceneError::Mistake(mistake))) = &ran.written else {
        panic!("{name}: {:?}", ran.written)
    };
    let under = text.lines().nth(mistake.line - 1).unwrap();
    let under: String = under.chars().skip(mistake.column - 1).collect();
    (mistake.path.clone(), mistake.message.clone(), mistake.line, under)
}

const IDENTITY: &str = "\"identity\": { \"value\": 1 }";
const SMOOTH: &str = "\"dense\": { \"value\": 1, \"correlation\": { \"function\": \"gaussian\", \"length\": 0.008 }, \"nugget\": 0 }";
const LOGNORMAL: &str = "\"lognormal\": { \"coefficient_of_variation\": 0.1 }";

/// Replaced text, replacement, key, part of the message, and underlined text.
const MISTAKES: [[&str; 5]; 17] = [
    [
        "{ \"shells\": 2 }",
        "{ \"length\": 0.0009 }",
        "bonds.horizon.length",
        "the horizon is 0.0009; it must be greater than the spacing 0.001 of the nodes",
        "0.0009",
    ],
    [
        "\"mouth\": [0, 0.008], \"tip\": [0.006, 0.008]",
        "\"mouth\": [0, 0.02], \"tip\": [0.006, 0.02]",
        "notch",
        "the notch cuts no bond: it lies outside the body",
        "\"notch\"",
    ],
    ["[0.006, 0.008]", "[0.02, 0.008]", "notch.tip", "lies outside the body", "\"tip\""],
    [
        "\"mouth\": [0, 0.008]",
        "\"mouth\": [0.003, 0.008]",
        "notch.mouth",
        "the mouth of the notch, [0.003, 0.008] m, is on no edge",
        "\"mouth\"",
    ],
    [
        "\"spacing\": 0.001",
        "\"spacing\": 0.001, \"holes\": [{ \"circle\": { \"centre\": [0.006, 0.008], \"radius\": 0.002 } }]",
        "notch.tip",
        "lies in hole 0",
        "\"tip\"",
    ],
    ["\"spacing\": 0.001", "\"spacing\": 0.000001", "body.spacing", "2.560e8 nodes", "0.000001"],
    ["[0.006, 0.008]", "[0.015, 0.008]", "notch.tip", "no room for a crack", "\"tip\""],
    [IDENTITY, SMOOTH, "dynamics.overdamped.mobility.dense.nugget", "not positive definite", "0 }"],
    [
        "\"realisations\": 12",
        "\"realisations\": 0",
        "ensemble.realisations",
        "0 realisations",
        "0,",
    ],
    [
        LOGNORMAL,
        "\"normal\": { \"coefficient_of_variation\": 0.2 }",
        "strength.field.marginal.normal.coefficient_of_variation",
        "lies below 0 with the probability",
        "0.2",
    ],
    [
        "{ \"shells\": 2 }",
        "{ \"length\": 0.002 }",
        "bonds.horizon.length",
        "sqrt(4) spacings",
        "0.002",
    ],
    ["\"z\": 0.9", "\"z\": 2", "time.step.z", "2 in units of the stiffest mode", "2 }"],
    [
        "\"steps\": 400",
        "\"steps\": 400, \"breaking\": \"bridge\"",
        "time.breaking",
        "Leimkuhler",
        "\"bridge\"",
    ],
    ["[0, 11]", "[0, 12]", "output.vtu[1]", "there is no realisation 12", "12]"],
    ["[0.016, 0.016]", "[0.016, 0.0165]", "body.size[1]", "16.5 spacings", "0.0165"],
    ["\"ratio\": 20", "\"ratio\": -1", "dynamics.overdamped.temperature.ratio", "-1", "-1"],
    ["\"windows\": 10", "\"windows\": 500", "output.windows", "500 windows", "500"],
];

#[test]
fn mistakes_are_shown_where_they_stand() {
    for [right, wrong, path, words, under] in MISTAKES {
        let name = format!("mistake-{}", path.replace(['.', '['], "-"));
        let found = mistake(&name, &with(&[(right, wrong)]));
        assert_eq!(found.0, path, "{}", found.1);
        assert!(found.1.contains(words), "{}", found.1);
        assert!(found.3.starts_with(under), "{path}: {}", found.3);
    }
}

#[test]
fn a_coupled_mobility_refuses_grips_that_slide_and_inertia_needs_a_density() {
    let coupled = "\"dense\": { \"value\": 2, \"correlation\": { \"function\": \"gaussian\", \"length\": 0.002 }, \"nugget\": 0.1 }";
    let changes = [("\"identity\": { \"value\": 1 }", coupled), ("\"clamped\"", "\"sliding\"")];
    assert_eq!(mistake("sliding", &with(&changes)).0, "grips.hold");
    let overdamped = PLATE.split("\"dynamics\": ").nth(1).unwrap().split(",\n  \"time\"").next();
    let inertial = "{ \"inertial\": { \"friction\": 1e6, \"temperature\": \"zero\" } }";
    let changes = [(overdamped.unwrap(), inertial), ("\"density\": 2440, ", "")];
    let found = mistake("density", &with(&changes));
    assert_eq!(found.0, "material");
    assert!(found.1.contains("density"));
}

#[test]
fn realisations_of_a_checkpoint_that_are_not_the_first_asked_for_are_refused_and_kept() {
    let of = |n: u64| {
        with(&[
            ("\"steps\": 400", "\"steps\": 10"),
            ("\"realisations\": 12", &format!("\"realisations\": {n}")),
            ("[0, 11]", "[]"),
        ])
    };
    let ran = run_text(&of(6));
    ran.result();
    let second = EnsemblePart::Shard("2/2".parse().unwrap());
    let shard = || Options { part: second.clone(), ..Options::new(ran.folder().join("shard")) };
    ran.again(&shard()).unwrap();
    for (n, options, words) in [
        (
            4,
            Options::new(ran.folder().join("out")),
            "6 realisations from number 0 on; requested are 4",
        ),
        (8, shard(), "3 realisations from number 3 on; requested are 4 from number 4 on"),
    ] {
        std::fs::write(ran.folder().join("scene.json"), of(n)).unwrap();
        let checkpoint = options.out.join("checkpoint-1.bin");
        let kept = std::fs::read(&checkpoint).unwrap();
        let refused = ran.again(&Options { start: Start::GoOn, ..options }).unwrap_err();
        let RunError::Solver(error) = refused else { panic!("{refused}") };
        assert!(error.to_string().contains(words), "{error}");
        assert_eq!(std::fs::read(&checkpoint).unwrap(), kept);
    }
}

/// The step exceeds every stable step, which only the built body shows.
#[test]
fn a_file_that_is_no_shard_is_refused_before_the_body_is_built() {
    let ran = run_text(&with(&[("\"z\": 0.9", "\"dt\": 1")]));
    assert!(matches!(&ran.written, Err(RunError::Scene(_))), "{:?}", ran.written);
    let part = EnsemblePart::Merged(vec![ran.folder().join("scene.json")]);
    let joined = ran.again(&Options { part, ..Options::new(ran.folder().join("joined")) });
    assert!(matches!(joined, Err(RunError::Checkpoint(CheckpointError::Refused(_)))), "{joined:?}");
}

#[test]
fn an_unknown_key_is_told_the_nearest() {
    let ran = run_text(&with(&[("\"spacing\"", "\"spaceing\"")]));
    let Err(RunError::Scene(error)) = &ran.written else { panic!("{:?}", ran.written) };
    let help = error.mistake().and_then(|mistake| mistake.help.clone());
    assert_eq!(help.as_deref(), Some("did you mean `spacing`?"));
}

#[test]
fn built_in_scenes_can_be_read_and_built() {
    use scenes::peridyn::points::Cloud;
    use scenes::peridyn::scene::CrackScene;
    use scenes::peridyn::scene_problem::CrackProblem;
    use scenes::scene::SceneFile;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/peridyn");
    let mut n_scenes = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "json") {
            continue;
        }
        let file = SceneFile::read(&path).unwrap();
        if file.text_at_top("solver").unwrap() != "peridyn-sde" {
            continue;
        }
        let scene: CrackScene = file.parse().unwrap();
        let cloud = Cloud::of_body(&scene.body, file.folder()).unwrap();
        let nodes = CrackProblem::new(&scene, cloud).unwrap().resolved.nodes;
        let whole = scene.body.size.iter().map(|side| side / scene.body.spacing).product::<f64>();
        let holes = whole - nodes as f64;
        assert!(if scene.body.holes.is_empty() { holes < 0.5 } else { holes > 0.5 });
        n_scenes += 1;
    }
    assert!(n_scenes >= 4);
}
