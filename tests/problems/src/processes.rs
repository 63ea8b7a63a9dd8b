//! Runs of scenes in separate processes, and the parts of their results that must be identical.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use fpk_scenes::method_scene::MethodScene as FpkMethod;
use fpk_scenes::scene::{CloudScene, FpkScene, PlanesScene, Times};
use peridyn_scenes::crack_inference::scene::{
    DesignScene, InferenceScene, MeasuredScene, PredictiveScene, SamplerScene,
};
use peridyn_scenes::scene::CrackScene;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use smpm_scenes::method_scene::{MethodScene, MultilevelScene};
use smpm_scenes::scene::{SmpmScene, TimeScene};

use crate::context::CaseError;

/// A built-in scene, reduced in size.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Its name.
    pub name: &'static str,
    content: Value,
    /// The same scene with an earlier end, if a longer run can continue it.
    shorter: Option<Value>,
    /// Whether it supports shards.
    pub shards: bool,
}

/// For each solver a density or a single run, if it has one, and an ensemble.
pub fn scenes() -> Result<Vec<Scene>, CaseError> {
    Ok(vec![
        density()?,
        paths()?,
        derivatives_of_a_plate()?,
        samples_of_a_plate()?,
        grids_of_a_plate()?,
        cracks(32)?,
        inference()?,
    ])
}

fn density() -> Result<Scene, CaseError> {
    let mut scene: FpkScene =
        built_in(include_str!("../../../tests/scenes/fpk/viscous_damper.json"))?;
    scene.times = Times { until: 5.0, every: 0.25 };
    let states = vec![["q", "v"].map(str::to_owned)];
    scene.planes = Some(PlanesScene { states, times: vec![1.0, 2.0] });
    scene.cloud = Some(CloudScene { every_observations: 4 });
    let named = Scene::new("density", &scene, false)?;
    scene.times.until = 3.0;
    named.shortened(&scene)
}

fn paths() -> Result<Scene, CaseError> {
    let mut scene: FpkScene = built_in(include_str!("../../../tests/ensembles/damper.json"))?;
    if let FpkMethod::MonteCarlo { paths, .. } = &mut scene.method {
        *paths = 300_000;
    }
    Scene::new("paths", &scene, true)
}

fn plate() -> Result<SmpmScene, CaseError> {
    built_in(include_str!("../../../tests/scenes/smpm/plate_impact.json"))
}

fn derivatives_of_a_plate() -> Result<Scene, CaseError> {
    use TimeScene::{At, Mean};
    let mut scene = plate()?;
    scene.grid.cell = 0.02;
    scene.times = vec![At(0.5), Mean([0.5, 1.0]), At(1.0), Mean([1.0, 2.0]), At(2.0)];
    scene.fields = true;
    let named = Scene::new("derivatives-of-a-plate", &scene, false)?;
    scene.times.truncate(3);
    named.shortened(&scene)
}

fn samples_of_a_plate() -> Result<Scene, CaseError> {
    let mut scene = plate()?;
    let sampled = |samples| MethodScene::MonteCarlo { samples, seed: 7, control: true };
    scene.method = sampled(400);
    let named = Scene::new("samples-of-a-plate", &scene, true)?;
    scene.method = sampled(150);
    named.shortened(&scene)
}

fn grids_of_a_plate() -> Result<Scene, CaseError> {
    let mut scene = plate()?;
    let to = |tolerance| MethodScene::Multilevel(MultilevelScene::new(tolerance, 7));
    scene.method = to(0.02);
    let named = Scene::new("grids-of-a-plate", &scene, false)?;
    scene.method = to(0.05);
    named.shortened(&scene)
}

/// A crack scene with a number of realisations.
pub fn cracks(realisations: u64) -> Result<Scene, CaseError> {
    let text = include_str!("../../../tests/scenes/peridyn/notched_plate_ensemble.json");
    let mut scene: CrackScene = built_in(text)?;
    scene.ensemble.realisations = realisations;
    scene.time.as_mut().ok_or("the scene has no steps")?.steps = 600;
    scene.output.vtu = vec![0, 12];
    let named = Scene::new("cracks", &scene, true)?;
    scene.ensemble.realisations = 20;
    named.shortened(&scene)
}

/// Toughness from measured plates: a few points of a design, with more realisations than run at a time.
fn inference() -> Result<Scene, CaseError> {
    let mut scene: InferenceScene =
        built_in(include_str!("../../../tests/scenes/peridyn/infer_toughness.json"))?;
    let folder = crate::record::workspace().join("tests/scenes/peridyn");
    let MeasuredScene { paths, failure_loads, .. } = &mut scene.measured;
    for file in
        [Some(&mut scene.plate), paths.as_mut(), failure_loads.as_mut()].into_iter().flatten()
    {
        *file = folder.join(&*file).display().to_string();
    }
    scene.parameters.truncate(1);
    scene.design = DesignScene { points: 9, realisations: 64, emulators: 8 };
    scene.sampler = SamplerScene { particles: 100, draws: 200, ..SamplerScene::default() };
    scene.predictive = PredictiveScene { draws: 4, realisations: 16 };
    let named = Scene::new("inference", &scene, false)?;
    scene.design.points = 7;
    named.shortened(&scene)
}

fn built_in<T: DeserializeOwned>(text: &str) -> Result<T, CaseError> {
    Ok(serde_json::from_str(text)?)
}

impl Scene {
    fn new(name: &'static str, scene: &impl Serialize, shards: bool) -> Result<Self, CaseError> {
        Ok(Self { name, content: serde_json::to_value(scene)?, shorter: None, shards })
    }

    fn shortened(self, shorter: &impl Serialize) -> Result<Self, CaseError> {
        Ok(Self { shorter: Some(serde_json::to_value(shorter)?), ..self })
    }

    /// Writes the scene as a file into a folder.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, CaseError> {
        let path = folder.join(format!("{}.json", self.name));
        scene_runs::output::write_json(&path, &self.content)?;
        Ok(path)
    }

    /// Writes the shorter scene, if there is one.
    pub fn write_shorter(&self, folder: &Path) -> Result<Option<PathBuf>, CaseError> {
        let Some(shorter) = &self.shorter else { return Ok(None) };
        let path = folder.join(format!("{}-shorter.json", self.name));
        scene_runs::output::write_json(&path, shorter)?;
        Ok(Some(path))
    }
}

/// First argument that turns a program with the scenes command into that command.
pub const AS_SCENES: &str = "scenes";

/// This program as the scenes command.
pub fn command_of_scenes() -> Result<Command, CaseError> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg(AS_SCENES);
    Ok(command)
}

/// Starts this program on a scene.
pub fn started(scene: &Path, out: &Path, more: &[&str]) -> Result<Child, CaseError> {
    let mut command = command_of_scenes()?;
    command.arg("run").arg(scene).arg("--out").arg(out);
    command.args(["--checkpoint-every", "0"]).args(more);
    piped(command)
}

/// Starts a command and captures its stderr.
pub fn piped(mut command: Command) -> Result<Child, CaseError> {
    Ok(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?)
}

/// Waits for the end of a run and returns its stderr.
///
/// # Errors
/// The stderr of a failed run.
pub fn finish(child: Child) -> Result<String, CaseError> {
    let output = child.wait_with_output()?;
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(told) } else { Err(told.into()) }
}

/// All numbers and texts of a result except those of machine and clock, and its series files by their bytes.
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
    let mut folders: Vec<PathBuf> = ["cloud", "fields"]
        .map(|name| folder.join(name))
        .into_iter()
        .filter(|it| it.exists())
        .collect();
    while let Some(series) = folders.pop() {
        for file in std::fs::read_dir(series)? {
            let path = file?.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).unwrap_or(&path).display();
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
                // Writing to a string cannot fail.
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
