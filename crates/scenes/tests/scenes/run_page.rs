//! The page of one run of each solver: its content, and in a browser where one is installed.

use std::io::Write;
use std::path::{Path, PathBuf};

use result_figures::number::short;
use scenes::{ALL, Options, Progress, run};
use serde_json::Value;

use crate::drive::{axe, browser, drive, violations, width_in_a_narrow_frame};

/// Largest page (bytes).
const MOST_BYTES: usize = 3_000_000;

/// A title that would run if it were not escaped.
const HOSTILE: &str = "</script><script>document.body.dataset.hostile = 1</script>";

pub(crate) const DENSITY: &str = r#"{
  "solver": "fpk-sph",
  "title": "TITLE",
  "system": {
    "duffing": {
      "structure": { "natural_frequency": 1, "damping_ratio": 0.05, "noise_intensity": 0.1, "window": "stationary" },
      "cubic_stiffness": 0.5
    }
  },
  "initial": { "gaussian": { "mean": [0, 0], "standard_deviation": [0.7, 0.9] } },
  "method": { "flow_map_fit": { "spacing": 0.5, "reach": 4 } },
  "times": { "until": 0.5, "every": 0.1 },
  "moments": [[2, 0], [0, 2]],
  "thresholds": [1, 2],
  "planes": { "states": [["q", "v"]], "times": [0.1, 0.5] }
}"#;

pub(crate) const BODIES: &str = r#"{
  "solver": "smpm",
  "title": "TITLE",
  "units": "cm_g_us",
  "dimension": 2,
  "grid": { "cell": 0.5, "particles_per_cell": 2 },
  "boundaries": [{ "axis": 1, "position": 0, "side": "above", "kind": "symmetry" }],
  "materials": { "steel": { "equation": { "mie_gruneisen": { "library": "steel" } } } },
  "bodies": [
    {
      "name": "plate",
      "material": "steel",
      "shape": { "box": { "from": [0, 0], "to": [4, 2] } },
      "velocity": [-0.1, 0]
    }
  ],
  "random": [{ "parameter": "steel.equation.s1", "law": "normal", "coefficient_of_variation": 0.05 }],
  "method": "propagated",
  "gauges": [{ "name": "wake", "body": "plate", "at": [1, 1] }],
  "quantities": ["pressure"],
  "times": [0.5, 1, 1.5],
  "fields": true
}"#;

pub(crate) const PLATE: &str = r#"{
  "solver": "peridyn-sde",
  "title": "TITLE",
  "body": { "size": [0.016, 0.016], "spacing": 0.001, "condition": { "plane_stress": { "thickness": 0.001 } } },
  "material": { "young_modulus": 72e9, "density": 2440, "toughness": { "energy_release_rate": 3.8 } },
  "bonds": { "horizon": { "shells": 3 }, "volume_correction": "ramp" },
  "notch": { "mouth": [0, 0.008], "tip": [0.005, 0.008] },
  "grips": { "height": 0.003, "hold": "sliding" },
  "loading": { "stretch": { "strain": { "over_critical_stretch": 1.6 } } },
  "dynamics": { "inertial": { "friction": 3e5, "temperature": "zero" } },
  "time": { "step": { "z": 1.6 }, "steps": 400 },
  "strength": {
    "field": {
      "marginal": { "lognormal": { "coefficient_of_variation": 0.2 } },
      "correlation": { "function": "matern32", "length": 0.004 },
      "between_nodes": "mean"
    }
  },
  "ensemble": { "realisations": 4, "seed": 7, "precision": "f32" },
  "output": { "vtu": [0, 2], "windows": 10 }
}"#;

pub(crate) const BUILDING: &str = r#"{
  "solver": "random-vibration",
  "title": "TITLE",
  "building": {
    "mass": [10000, 10000],
    "stiffness": [40e6, 40e6],
    "damping": { "rayleigh": { "modes": [1, 2], "ratios": [0.04, 0.04] } },
    "hysteresis": "none"
  },
  "ground": { "soil": { "kanai_tajimi": { "ground_frequency": 15.6, "ground_damping": 0.6 } }, "noise_intensity": 0.04 },
  "response": { "storey": 1 },
  "thresholds": [0.002, 0.003],
  "times": { "until": 2, "every": 0.5 },
  "method": { "monte_carlo": { "paths": 2000, "step": 0.01, "seed": 1 } }
}"#;

/// A run in a folder of its own, with a title that is markup.
struct Ran {
    folder: PathBuf,
    html: String,
    result: Value,
}

impl Ran {
    fn new(name: &str, scene: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("page-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("scene.json");
        std::fs::write(&file, scene.replace("TITLE", HOSTILE)).unwrap();
        let out = folder.join("out");
        let written = run(ALL, &file, &Options::new(&out), &Progress::silent()).unwrap().files;
        assert!(written.contains(&out.join("index.html")), "{written:?}");
        let html = std::fs::read_to_string(out.join("index.html")).unwrap();
        assert!(html.len() < MOST_BYTES, "{}", html.len());
        let text = std::fs::read_to_string(out.join("result.json")).unwrap();
        Self { folder, html, result: serde_json::from_str(&text).unwrap() }
    }

    /// What a reader sees, where there is a browser; checks what holds on every page.
    fn seen(&self) -> Option<Value> {
        let Some(browser) = browser() else {
            let _ = writeln!(std::io::stderr(), "skipped: no Chromium is installed");
            return None;
        };
        let seen = drive(&browser, &self.html);
        for empty in ["errors", "requests", "unlabelled"] {
            assert_eq!(seen[empty], serde_json::json!([]), "{empty}");
        }
        assert!(seen["hostile"].is_null());
        for motion in seen["motions"].as_array().unwrap() {
            assert!(motion["moves"] == true || motion["frames"] == 1, "{motion:#}");
        }
        for theme in seen["themes"].as_array().unwrap() {
            assert!(theme["contrast"].as_f64().unwrap() >= 4.5, "{theme:#}");
        }
        if let Some(axe) = axe() {
            let found = violations(&browser, &axe, &self.html);
            assert_eq!(found["violations"], serde_json::json!([]), "{found:#}");
        }
        let width = width_in_a_narrow_frame(&browser, &self.html);
        assert!(width <= 400.0, "{width}");
        Some(seen)
    }

    fn number(&self, pointer: &str) -> f64 {
        self.result
            .pointer(pointer)
            .and_then(Value::as_f64)
            .unwrap_or_else(|| panic!("no {pointer}"))
    }
}

impl Drop for Ran {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// The first number after the name of a line in the readout of a chart.
fn shown(line: &Value) -> f64 {
    let (_, value) = line.as_str().unwrap().rsplit_once(": ").unwrap();
    value.split([' ', ',', ';']).next().unwrap().parse().unwrap()
}

/// The readout agrees with a number of the result within the six digits, or those that its error leaves.
fn assert_shown(line: &Value, value: f64, error: Option<f64>) {
    let digits = 5e-6 * value.abs();
    let tolerance = error.map_or(digits, |error| digits.max(0.05 * error));
    assert!((shown(line) - value).abs() <= tolerance * (1.0 + 1e-9), "{line} for {value}");
}

#[test]
fn the_page_of_a_density_moves_and_shows_the_numbers_of_the_result() {
    let ran = Ran::new("density", DENSITY);
    assert!(ran.html.contains("Marginal density of q and v"));
    // A key that the scene leaves out, with its default.
    assert!(ran.html.contains("method.flow_map_fit.scheme"));
    let Some(seen) = ran.seen() else { return };
    assert_eq!(seen["motions"][0]["frames"], 2);
    // The last chart has the moments of order two.
    let chart = seen["charts"].as_array().unwrap().last().unwrap();
    let end = ran.result["quantities"][0]["values"].as_array().unwrap().last().unwrap();
    assert_eq!(ran.result["quantities"][0]["id"], "moment/2-0");
    assert_shown(&chart["end"][1], end["value"].as_f64().unwrap(), end["error"].as_f64());
}

#[test]
fn the_page_of_bodies_moves_and_shows_the_numbers_of_the_result() {
    let ran = Ran::new("bodies", BODIES);
    let Some(seen) = ran.seen() else { return };
    let motion = &seen["motions"][0];
    // Pressure and density, each with mean and deviation.
    assert_eq!((&motion["frames"], &motion["layers"]), (&3.into(), &4.into()));
    assert!(
        motion["texts"][1].as_str().unwrap().starts_with("t = 1.5 us: pressure mean"),
        "{motion:#}"
    );
    let mean = ran.number("/gauges/0/quantities/0/values/0/mean");
    assert_shown(&seen["charts"][0]["home"][1], mean, None);
}

#[test]
fn the_page_of_cracks_has_the_map_the_realisations_and_the_loads_of_the_result() {
    let ran = Ran::new("plate", PLATE);
    assert!(ran.html.contains("Map of damage") && ran.html.contains("Growth of cracks"));
    let series = ran.folder.join("out/fields/realisation-0002.pvd");
    let n_times = std::fs::read_to_string(series).unwrap().matches("<DataSet").count();
    let Some(seen) = ran.seen() else { return };
    // The series and the page show the same times, and most of them lie within the growth of the cracks.
    assert_eq!([&seen["motions"][0]["frames"], &seen["motions"][1]["frames"]], [1, n_times]);
    assert!(n_times > 10, "{n_times}");
    let end = format!("t = {} s", short(ran.result["resolved"]["duration"].as_f64()));
    assert_eq!(seen["motions"][1]["value"], end);
    let load = &ran.result["load"][9]["load"];
    assert_shown(
        &seen["charts"][0]["end"][1],
        load["value"].as_f64().unwrap(),
        load["error"].as_f64(),
    );
}

#[test]
fn the_page_of_a_building_has_its_probabilities_and_says_why_nothing_moves() {
    let ran = Ran::new("building", BUILDING);
    assert!(
        ran.html.contains("has no field over time to show")
            && !ran.html.contains("class=\"motion\"")
    );
    let Some(seen) = ran.seen() else { return };
    let last = ran.result["quantities"][0]["values"].as_array().unwrap().last().unwrap();
    let line = &seen["charts"][0]["end"][1];
    assert_shown(line, last["value"].as_f64().unwrap(), last["error"].as_f64());
    assert!(line.as_str().unwrap().contains("standard error of the samples"), "{line}");
}

#[test]
fn the_command_ends_with_answers_or_with_paths_alone() {
    let folder = std::env::temp_dir().join(format!("page-command-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("scene.json");
    std::fs::write(&file, BUILDING.replace("TITLE", "two storeys")).unwrap();
    let run = |more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_scenes"));
        command
            .arg("run")
            .arg(&file)
            .arg("--out")
            .arg(folder.join("out"))
            .arg("--overwrite")
            .args(more);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let answers = run(&[]);
    let lines: Vec<&str> = answers.lines().collect();
    assert!((3..=10).contains(&lines.len()), "{answers}");
    assert!(lines[0].contains("> 0.002), t = 2 s") && lines[0].contains(" ± "), "{answers}");
    assert!(
        lines.last().unwrap().starts_with("written: ") && answers.contains("index.html"),
        "{answers}"
    );
    let paths = run(&["--quiet"]);
    assert!(paths.lines().all(|line| Path::new(line).exists()), "{paths}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_run_at_its_next_checkpoint_and_it_resumes_to_the_same_bits() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let folder = std::env::temp_dir().join(format!("page-signal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("scene.json");
    let scene =
        PLATE.replace("TITLE", "long").replace("\"realisations\": 4", "\"realisations\": 320");
    std::fs::write(&file, scene).unwrap();
    let command = |out: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenes"));
        command.arg("run").arg(&file).arg("--out").arg(folder.join(out)).args(more);
        command
    };
    let mut child = command("ended", &[]).stderr(Stdio::piped()).spawn().unwrap();
    // The first line reports that realisations run.
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    lines.by_ref().find(|line| line.as_ref().unwrap().contains("realisations")).unwrap().unwrap();
    let killed = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("holds the run")), "{rest:?}");
    assert!(!folder.join("ended/result.json").exists());
    for (out, more) in [("ended", "--resume"), ("whole", "--overwrite")] {
        let output = command(out, &[more]).output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
    let loads = |out: &str| {
        let text = std::fs::read_to_string(folder.join(out).join("result.json")).unwrap();
        let result: Value = serde_json::from_str(&text).unwrap();
        [result["load"].clone(), result["realisations"].clone()]
    };
    assert_eq!(loads("ended"), loads("whole"));
    std::fs::remove_dir_all(&folder).unwrap();
}
