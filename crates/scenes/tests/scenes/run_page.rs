//! The page of one run of each solver: its content, and in a browser where one is installed.

use std::io::Write;
use std::path::Path;

use result_figures::number::short;
use serde_json::Value;

use crate::drive::{axe, browser, drive, violations, width_in_a_narrow_frame};
use crate::harness::{SceneRun, changed, result_in};

/// Largest page (bytes).
const MOST_BYTES: usize = 3_000_000;

/// A title that would run if it were not escaped.
const HOSTILE: &str = "</script><script>document.body.dataset.hostile = 1</script>";

pub(crate) const DENSITY: &str = include_str!("../small/fpk/density.json");
pub(crate) const BODIES: &str = include_str!("../small/smpm/bodies.json");
pub(crate) const PLATE: &str = include_str!("../small/peridyn/plate.json");
pub(crate) const BUILDING: &str = include_str!("../small/fpk/building.json");

/// A run, with a title that is markup.
struct Page {
    ran: SceneRun,
    html: String,
    result: Value,
}

impl Page {
    fn of(scene: &str) -> Self {
        let ran = SceneRun::of(&scene.replace("TITLE", HOSTILE));
        let (result, page) = (ran.result(), ran.out().join("index.html"));
        assert!(ran.written.as_ref().is_ok_and(|files| files.contains(&page)), "{:?}", ran.written);
        let html = std::fs::read_to_string(page).unwrap();
        assert!(html.len() < MOST_BYTES, "{}", html.len());
        Self { ran, html, result }
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
    let page = Page::of(DENSITY);
    assert!(page.html.contains("Marginal density of q and v"));
    // A key that the scene leaves out, with its default.
    assert!(page.html.contains("method.flow_map_fit.scheme"));
    let Some(seen) = page.seen() else { return };
    assert_eq!(seen["motions"][0]["frames"], 2);
    // The last chart has the moments of order two.
    let chart = seen["charts"].as_array().unwrap().last().unwrap();
    let end = page.result["quantities"][0]["values"].as_array().unwrap().last().unwrap();
    assert_eq!(page.result["quantities"][0]["id"], "moment/2-0");
    assert_shown(&chart["end"][1], end["value"].as_f64().unwrap(), end["error"].as_f64());
}

#[test]
fn the_page_of_bodies_moves_and_shows_the_numbers_of_the_result() {
    let page = Page::of(BODIES);
    let Some(seen) = page.seen() else { return };
    let motion = &seen["motions"][0];
    // Pressure and density, each with mean and deviation.
    assert_eq!((&motion["frames"], &motion["layers"]), (&3.into(), &4.into()));
    assert!(
        motion["texts"][1].as_str().unwrap().starts_with("t = 1.5 us: pressure mean"),
        "{motion:#}"
    );
    let mean = page.result["gauges"][0]["quantities"][0]["values"][0]["mean"].as_f64().unwrap();
    assert_shown(&seen["charts"][0]["home"][1], mean, None);
}

#[test]
fn the_page_of_cracks_has_the_map_the_realisations_and_the_loads_of_the_result() {
    let page = Page::of(PLATE);
    assert!(page.html.contains("Map of damage") && page.html.contains("Growth of cracks"));
    let series = page.ran.out().join("fields/realisation-0002.pvd");
    let n_times = std::fs::read_to_string(series).unwrap().matches("<DataSet").count();
    let Some(seen) = page.seen() else { return };
    // The series and the page show the same times, and most of them lie within the growth of the cracks.
    assert_eq!([&seen["motions"][0]["frames"], &seen["motions"][1]["frames"]], [1, n_times]);
    assert!(n_times > 10, "{n_times}");
    let end = format!("t = {} s", short(page.result["resolved"]["duration"].as_f64()));
    assert_eq!(seen["motions"][1]["value"], end);
    let load = &page.result["load"][9]["load"];
    assert_shown(
        &seen["charts"][0]["end"][1],
        load["value"].as_f64().unwrap(),
        load["error"].as_f64(),
    );
}

#[test]
fn the_page_of_a_building_has_its_probabilities_and_says_why_nothing_moves() {
    let page = Page::of(BUILDING);
    assert!(
        page.html.contains("has no field over time to show")
            && !page.html.contains("class=\"motion\"")
    );
    let Some(seen) = page.seen() else { return };
    let last = page.result["quantities"][0]["values"].as_array().unwrap().last().unwrap();
    let line = &seen["charts"][0]["end"][1];
    assert_shown(line, last["value"].as_f64().unwrap(), last["error"].as_f64());
    assert!(line.as_str().unwrap().contains("standard error of the samples"), "{line}");
}

#[test]
fn the_command_ends_with_answers_or_with_paths_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.json");
    std::fs::write(&file, BUILDING.replace("TITLE", "two storeys")).unwrap();
    let run = |more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_scenes"));
        command.arg("run").arg(&file).arg("--out").arg(folder.path().join("out"));
        command.arg("--overwrite").args(more);
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
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_run_at_its_next_checkpoint_and_it_resumes_to_the_same_bits() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.json");
    std::fs::write(&file, changed(PLATE, &[("'realisations': 4", "'realisations': 320")])).unwrap();
    let command = |out: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenes"));
        command.arg("run").arg(&file).arg("--out").arg(folder.path().join(out)).args(more);
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
    assert!(!folder.path().join("ended/result.json").exists());
    for (out, more) in [("ended", "--resume"), ("whole", "--overwrite")] {
        let output = command(out, &[more]).output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
    let loads = |out: &str| {
        let result = result_in(&folder.path().join(out));
        [result["load"].clone(), result["realisations"].clone()]
    };
    assert_eq!(loads("ended"), loads("whole"));
}
