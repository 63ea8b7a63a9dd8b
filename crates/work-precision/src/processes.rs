//! Runs of scenes by this program, and what of their results must be the same.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use crate::context::CaseError;

/// A built-in scene, made smaller.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Its name.
    pub name: &'static str,
    text: &'static str,
    /// JSON pointers and what stands there instead.
    changes: Vec<Change>,
    /// What makes it shorter, where a longer run goes on from a shorter one.
    pub shorter: Option<Change>,
    /// Whether it can be divided.
    pub shards: bool,
}

/// A JSON pointer and the value that takes its place.
pub type Change = (&'static str, Value);

/// Of each solver a density or a single run, where it has one, and an ensemble.
pub fn scenes() -> Vec<Scene> {
    let damper = include_str!("../../../tests/scenes/fpk/viscous_damper.json");
    let plate = include_str!("../../../tests/scenes/smpm/plate_impact.json");
    let judge = json!({ "samples": 400, "seed": 7, "control": true });
    vec![
        Scene {
            name: "density",
            text: damper,
            changes: vec![
                ("/times", json!({ "until": 5, "every": 0.1 })),
                ("/planes", json!({ "states": [["q", "v"]], "times": [1, 2] })),
                ("/cloud", json!({ "every_observations": 10 })),
            ],
            shorter: Some(("/times/until", json!(3))),
            shards: false,
        },
        Scene {
            name: "paths",
            text: include_str!("../../../tests/ensembles/damper.json"),
            changes: vec![("/method/monte_carlo/paths", json!(300_000))],
            shorter: None,
            shards: true,
        },
        Scene {
            name: "derivatives-of-a-plate",
            text: plate,
            changes: vec![
                ("/grid/cell", json!(0.02)),
                ("/times", json!([0.5, [0.5, 1], 1, [1, 2], 2])),
                ("/fields", json!(true)),
            ],
            shorter: Some(("/times", json!([0.5, [0.5, 1], 1]))),
            shards: false,
        },
        Scene {
            name: "samples-of-a-plate",
            text: plate,
            changes: vec![("/method", json!({ "monte_carlo": judge }))],
            shorter: Some(("/method/monte_carlo/samples", json!(150))),
            shards: true,
        },
        Scene {
            name: "cracks",
            text: include_str!("../../../tests/scenes/peridyn/notched_plate_ensemble.json"),
            changes: vec![
                ("/ensemble/realisations", json!(32)),
                ("/time/steps", json!(600)),
                ("/output/vtu", json!([0, 12])),
            ],
            shorter: Some(("/ensemble/realisations", json!(20))),
            shards: true,
        },
    ]
}

impl Scene {
    /// The scene, with one more change, as a file in a folder.
    ///
    /// # Errors
    /// A change at a place that the scene does not have; those of the file system.
    pub fn write(&self, folder: &Path, more: Option<&Change>) -> Result<PathBuf, CaseError> {
        let mut scene: Value = serde_json::from_str(self.text)?;
        for (pointer, value) in self.changes.iter().chain(more) {
            let (parent, key) = pointer.rsplit_once('/').ok_or("a pointer without a key")?;
            let object = scene.pointer_mut(parent).and_then(Value::as_object_mut);
            let object = object.ok_or_else(|| format!("no object at {parent}"))?;
            object.insert(key.into(), value.clone());
        }
        let end = if more.is_some() { "-shorter" } else { "" };
        let path = folder.join(format!("{}{end}.json", self.name));
        scenes::output::write_json(&path, &scene)?;
        Ok(path)
    }
}

/// By this word a program that links the command of scenes becomes it.
pub const AS_SCENES: &str = "scenes";

/// This program as the command of scenes.
///
/// # Errors
/// Those of the operating system.
pub fn command_of_scenes() -> Result<Command, CaseError> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg(AS_SCENES);
    Ok(command)
}

/// This program, at a scene.
///
/// # Errors
/// Those of the operating system.
pub fn started(scene: &Path, out: &Path, more: &[&str]) -> Result<Child, CaseError> {
    let mut command = command_of_scenes()?;
    command.arg("run").arg(scene).arg("--out").arg(out);
    command.args(["--checkpoint-every", "0"]).args(more);
    piped(command)
}

/// Starts a command whose words on stderr are kept.
///
/// # Errors
/// Those of the operating system.
pub fn piped(mut command: Command) -> Result<Child, CaseError> {
    Ok(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?)
}

/// Waits for the end of a run and gives what it has told.
///
/// # Errors
/// What it has told, where it failed.
pub fn finish(child: Child) -> Result<String, CaseError> {
    let output = child.wait_with_output()?;
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(told) } else { Err(told.into()) }
}

/// All numbers and words of a result, without those of the machine and the clock, and its files of series by their bytes.
///
/// # Errors
/// Those of the file system, and a result that is no JSON.
pub fn outcome(folder: &Path) -> Result<BTreeSet<String>, CaseError> {
    let text = std::fs::read_to_string(folder.join("result.json"))?;
    let mut result: Value = serde_json::from_str(&text)?;
    for (parent, key) in [("", "machine"), ("", "commit"), ("/work", "cpu_seconds")] {
        if let Some(object) = result.pointer_mut(parent).and_then(Value::as_object_mut) {
            object.remove(key);
        }
    }
    let mut entries = BTreeSet::new();
    flatten(&result, &mut String::new(), &mut entries);
    for series in ["cloud", "fields"].map(|name| folder.join(name)) {
        if !series.exists() {
            continue;
        }
        for file in std::fs::read_dir(series)? {
            let path = file?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            entries.insert(format!("{name} {:?}", std::fs::read(&path)?));
        }
    }
    Ok(entries)
}

/// `path value` for every leaf.
fn flatten(value: &Value, path: &mut String, entries: &mut BTreeSet<String>) {
    let length = path.len();
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                // A string takes what is written to it.
                let _ = write!(path, ".{key}");
                flatten(value, path, entries);
                path.truncate(length);
            }
        }
        Value::Array(array) => {
            for (i, value) in array.iter().enumerate() {
                let _ = write!(path, "[{i}]");
                flatten(value, path, entries);
                path.truncate(length);
            }
        }
        leaf => {
            entries.insert(format!("{path} {leaf}"));
        }
    }
}
