//! Runs that would take too long, and runs that are resumed.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use scenes::ladder::{Ladder, Limits, Outcome, climb};
use scenes::{ALL, SceneFile, kind_of};
use serde_json::Value;

use crate::run_page::{BODIES, BUILDING, DENSITY, PLATE};

/// A few microseconds.
const NEXT_TO_NOTHING: [&str; 2] = ["--longest", "1e-9"];

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("long-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn run(&self, scene: &str, out: &str, more: &[&str]) -> Output {
        let file = self.0.join("scene.json");
        std::fs::write(&file, scene).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenes"));
        command.arg("run").arg(&file).arg("--out").arg(self.0.join(out)).args(more);
        command.output().unwrap()
    }

    fn text(&self, file: impl AsRef<Path>) -> String {
        std::fs::read_to_string(self.0.join(file)).unwrap()
    }

    /// What a run found, without its cost and its machine.
    fn found(&self, out: &str) -> Value {
        let mut result: Value =
            serde_json::from_str(&self.text(format!("{out}/result.json"))).unwrap();
        for key in ["work", "machine", "commit"] {
            result.as_object_mut().unwrap().remove(key);
        }
        result
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A test that failed has said why.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The scene is refused by its pace, and then resumed to the result of one run.
pub(crate) fn refused_and_resumed(name: &str, scene: &str) {
    refused_and_resumed_beside(name, scene, &[]);
}

/// As [`refused_and_resumed`], with files beside the scene.
pub(crate) fn refused_and_resumed_beside(name: &str, scene: &str, files: &[(&str, &str)]) {
    let folder = Folder::new(name);
    for (name, text) in files {
        std::fs::write(folder.0.join(name), text).unwrap();
    }
    let refused = folder.run(scene, "pieces", &NEXT_TO_NOTHING);
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");
    let words = String::from_utf8(refused.stderr).unwrap();
    assert!(words.contains("so the rest takes about") && words.contains("--yes"), "{words}");
    assert!(!folder.0.join("pieces/result.json").exists());
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
    refused_and_resumed("density", DENSITY);
}

#[test]
fn sampled_paths_that_would_take_too_long_are_refused_and_go_on_where_they_were() {
    let fit = r#"{ "flow_map_fit": { "spacing": 0.5, "reach": 4 } }"#;
    let sampled = r#"{ "monte_carlo": { "paths": 100000, "step": 0.01, "seed": 1 } }"#;
    assert!(DENSITY.contains(fit));
    let planes = DENSITY.find(",\n  \"planes\"").unwrap();
    let scene = format!("{}\n}}", &DENSITY[..planes]).replace(fit, sampled);
    refused_and_resumed("paths", &scene);
    let more = BUILDING.replace("\"paths\": 2000", "\"paths\": 50000");
    refused_and_resumed("blocks", &more);
}

#[test]
fn bodies_that_would_take_too_long_are_refused_and_go_on_where_they_were() {
    refused_and_resumed("bodies", BODIES);
    let samples = r#"{ "monte_carlo": { "samples": 40, "seed": 3, "control": false } }"#;
    let scene = BODIES.replace("\"propagated\"", samples).replace("true", "false");
    refused_and_resumed("samples", &scene);
}

#[test]
fn realisations_that_would_take_too_long_are_refused_and_go_on_from_their_step() {
    refused_and_resumed("cracks", PLATE);
    let mut slow = PLATE.to_owned();
    for (from, to) in [
        (
            r#"{ "inertial": { "friction": 3e5, "temperature": "zero" } }"#,
            r#"{ "quasi_static": {} }"#,
        ),
        (r#""time": { "step": { "z": 1.6 }, "steps": 400 },"#, ""),
        (r#""hold": "sliding""#, r#""hold": "sliding", "protected": 0.005"#),
        (r#""realisations": 4"#, r#""realisations": 6"#),
        ("f32", "f64"),
    ] {
        assert!(slow.contains(from), "{from}");
        slow = slow.replace(from, to);
    }
    refused_and_resumed("slow", &slow);
}

#[test]
fn the_page_of_a_resumed_run_moves_from_the_beginning() {
    let folder = Folder::new("frames");
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
        let html = folder.text(format!("{out}/index.html"));
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
