//! Runs that would take too long, and runs that are resumed.

use std::path::PathBuf;
use std::process::{Command, Output};
use std::time::Duration;

use scenes::ladder::{Ladder, Limits, Outcome, climb};
use scenes::{ALL, SceneFile, kind_of};
use serde_json::Value;
use tempfile::TempDir;

use crate::harness::{changed, result_in};
use crate::run_page::{BODIES, BUILDING, DENSITY, PLATE};

/// A few microseconds.
const NEXT_TO_NOTHING: [&str; 2] = ["--longest", "1e-9"];

struct Folder(TempDir);

impl Folder {
    fn run(&self, scene: &str, out: &str, more: &[&str]) -> Output {
        let file = self.join("scene.json");
        std::fs::write(&file, scene).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenes"));
        command.arg("run").arg(&file).arg("--out").arg(self.join(out)).args(more);
        command.output().unwrap()
    }

    fn join(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    /// What a run found, without its cost and its machine.
    fn found(&self, out: &str) -> Value {
        let mut result = result_in(&self.join(out));
        for key in ["work", "machine", "commit"] {
            result.as_object_mut().unwrap().remove(key);
        }
        result
    }
}

/// The scene is refused by its pace, and then resumed to the result of one run.
pub(crate) fn refused_and_resumed(scene: &str) {
    refused_and_resumed_beside(scene, &[]);
}

/// As [`refused_and_resumed`], with files beside the scene.
pub(crate) fn refused_and_resumed_beside(scene: &str, files: &[(&str, &str)]) {
    let folder = Folder(tempfile::tempdir().unwrap());
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let refused = folder.run(scene, "pieces", &NEXT_TO_NOTHING);
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");
    let words = String::from_utf8(refused.stderr).unwrap();
    assert!(words.contains("so the rest takes about") && words.contains("--yes"), "{words}");
    assert!(!folder.join("pieces/result.json").exists());
    // Without --resume the kept part is not overwritten.
    let again = folder.run(scene, "pieces", &["--yes"]);
    assert_eq!(again.status.code(), Some(1), "{again:?}");
    for (out, more) in [("pieces", ["--resume", "--yes"].as_slice()), ("whole", &[])] {
        let ran = folder.run(scene, out, more);
        assert!(ran.status.success(), "{ran:?}");
    }
    assert_eq!(folder.found("pieces"), folder.found("whole"));
}

#[test]
fn a_density_that_would_take_too_long_is_refused_and_goes_on_where_it_was() {
    refused_and_resumed(DENSITY);
}

#[test]
fn sampled_paths_that_would_take_too_long_are_refused_and_go_on_where_they_were() {
    let scene = changed(
        DENSITY,
        &[
            (
                "{ 'flow_map_fit': { 'spacing': 0.5, 'reach': 4 } }",
                "{ 'monte_carlo': { 'paths': 100000, 'step': 0.01, 'seed': 1 } }",
            ),
            (",\n  'planes': { 'states': [['q', 'v']], 'times': [0.1, 0.5] }", ""),
        ],
    );
    refused_and_resumed(&scene);
    refused_and_resumed(&changed(BUILDING, &[("'paths': 2000", "'paths': 50000")]));
}

#[test]
fn methods_of_which_nothing_is_kept_are_refused_and_begin_again() {
    for method in [
        "{ 'conservative_grid': { 'cells': 64, 'reach': 6, 'steps_per_period': 40 } }",
        "{ 'statistical_linearisation': { 'step': 0.001 } }",
    ] {
        let folder = Folder(tempfile::tempdir().unwrap());
        let scene = changed(
            DENSITY,
            &[
                ("{ 'flow_map_fit': { 'spacing': 0.5, 'reach': 4 } }", method),
                (",\n  'planes': { 'states': [['q', 'v']], 'times': [0.1, 0.5] }", ""),
            ],
        );
        let refused = folder.run(&scene, "out", &NEXT_TO_NOTHING);
        assert_eq!(refused.status.code(), Some(1), "{refused:?}");
        let words = String::from_utf8(refused.stderr).unwrap();
        assert!(words.contains("so the rest takes about") && words.contains("--yes"), "{words}");
        assert!(!folder.join("out/result.json").exists());
        let ran = folder.run(&scene, "out", &["--yes"]);
        assert!(ran.status.success(), "{ran:?}");
    }
}

#[test]
fn bodies_that_would_take_too_long_are_refused_and_go_on_where_they_were() {
    refused_and_resumed(BODIES);
    let samples = "{ 'monte_carlo': { 'samples': 40, 'seed': 3, 'control': false } }";
    refused_and_resumed(&changed(BODIES, &[("'propagated'", samples), ("true", "false")]));
}

#[test]
fn realisations_that_would_take_too_long_are_refused_and_go_on_from_their_step() {
    refused_and_resumed(PLATE);
    let slow = [
        ("{ 'inertial': { 'friction': 3e5, 'temperature': 'zero' } }", "{ 'quasi_static': {} }"),
        ("'time': { 'step': { 'z': 1.6 }, 'steps': 400 },", ""),
        ("'hold': 'sliding'", "'hold': 'sliding', 'protected': 0.005"),
        ("'realisations': 4", "'realisations': 6"),
        ("f32", "f64"),
    ];
    refused_and_resumed(&changed(PLATE, &slow));
}

#[test]
fn the_page_of_a_resumed_run_moves_from_the_beginning() {
    let folder = Folder(tempfile::tempdir().unwrap());
    let shorter = BODIES.replace("[0.5, 1, 1.5]", "[0.5, 1]");
    for (scene, out, more) in [
        (shorter.as_str(), "pieces", [].as_slice()),
        (BODIES, "pieces", &["--resume"]),
        (BODIES, "whole", &[]),
    ] {
        let ran = folder.run(scene, out, more);
        assert!(ran.status.success(), "{ran:?}");
    }
    let motion = |out: &str| {
        let html = std::fs::read_to_string(folder.join(out).join("index.html")).unwrap();
        let lines = html.lines().filter(|line| line.contains("t = 0.5 us"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(!motion("whole").is_empty());
    assert_eq!(motion("pieces"), motion("whole"));
}

#[test]
fn a_method_whose_trials_are_dear_or_fail_is_left_after_the_first() {
    let file = SceneFile::from_text("density.json", DENSITY.to_owned()).unwrap();
    let kind = kind_of(ALL, &file).unwrap();
    let mut ladder = (kind.ladder)(&file).unwrap();
    let climbed = |ladder: &Ladder, budget, longest| {
        climb(kind, &file, ladder, 0, Limits { budget, longest }, |_, _| {})
    };
    let microsecond = Some(Duration::from_micros(1));
    let dear = climbed(&ladder, 1e-9, microsecond);
    assert_eq!(dear.len(), 1);
    let Outcome::Failed { reason, .. } = &dear[0].outcome else { panic!("{dear:?}") };
    assert!(reason.contains("so the rest takes about"), "{reason}");
    assert!(dear[0].cpu_seconds() > 0.0);
    // Trials that fail at no cost: three are made.
    let rung = std::mem::replace(&mut ladder.methods[0].rung, Box::new(|_| None));
    ladder.methods[0].rung = Box::new(move |size| {
        let mut rung = rung(size)?;
        rung.trial.insert("thresholds".to_owned(), "none".into());
        Some(rung)
    });
    assert_eq!(climbed(&ladder, 1e9, None).len(), 3);
    assert_eq!(climbed(&ladder, 1e-9, None).len(), 1);
}
