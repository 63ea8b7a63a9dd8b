//! The crack scene that an inference scene names, at any values of its parameters.

use std::path::Path;

use scene_runs::kind::KIND_KEY;
use scene_runs::nearest::nearest;
use scene_runs::scene::{NamedFile, Objection, Scene, SceneError, SceneFile};
use serde_json::{Value, json};

use super::scene::InferenceScene;
use crate::points::Cloud;
use crate::scene::CrackScene;
use crate::scene_problem::CrackProblem;

/// The solver of a crack scene.
const SOLVER: &str = "peridyn-sde";

/// Parts of a crack scene whose numbers are no parameters of the plate.
const ASIDE: [&str; 2] = ["ensemble", "output"];

/// The model of an inference scene.
#[derive(Debug)]
pub struct PlateModel {
    name: String,
    /// All keys with their defaults.
    keys: Value,
    cloud: Option<Cloud>,
    /// JSON pointers of the parameters.
    pointers: Vec<String>,
    parameters: Vec<String>,
    /// The scene as it is written, without its output.
    pub scene: CrackScene,
    /// The file of the scene, and those that it names.
    pub files: Vec<NamedFile>,
}

/// A plate at a point of the parameters.
#[derive(Debug)]
pub struct PlateAt {
    /// Its scene.
    pub scene: CrackScene,
    /// What a study of it borrows.
    pub problem: CrackProblem,
}

/// Error of the file of a plate.
#[derive(Debug)]
pub enum PlateError {
    /// A key of the inference scene is wrong.
    Here(Objection),
    /// The scene of the plate is wrong, at a place of its own file.
    There(SceneError),
}

impl PlateModel {
    /// Reads the plate of an inference scene and finds its parameters.
    ///
    /// # Errors
    /// [`PlateError::There`] for a crack scene that is invalid; [`PlateError::Here`] for a file that is missing or has another
    /// solver, for a parameter that is no number of the plate, and for an abscissa outside of it.
    pub fn read(scene: &InferenceScene, folder: &Path) -> Result<Self, PlateError> {
        let here = |path: &str, message: String| PlateError::Here(Objection::new(path, message));
        let name = &scene.plate;
        let (named, _) = NamedFile::read(name, folder)
            .map_err(|error| here("plate", format!("cannot read the plate {name}: {error}")))?;
        // Any file may be named: what it holds is shown only where it is a scene of cracks.
        let no_scene = |error: SceneError| here("plate", format!("{name} is no scene: {error}"));
        let file = SceneFile::read(&folder.join(name)).map_err(no_scene)?;
        let solver = file.text_at_top(KIND_KEY).map_err(no_scene)?;
        if solver != SOLVER {
            let message =
                format!("{name} is a scene of `{solver}`; the plate must be one of `{SOLVER}`");
            return Err(here("plate", message));
        }
        let mut plate: CrackScene = file.parse().map_err(PlateError::There)?;
        plate.output.vtu.clear();
        let there = |objection: Objection| PlateError::There(file.object_to(&objection));
        let cloud = Cloud::of_body(&plate.body, file.folder()).map_err(there)?;
        let keys = serde_json::to_value(&plate)
            .map_err(|error| here("plate", format!("{name} cannot be written again: {error}")))?;
        let pointers = pointers(scene, &keys).map_err(PlateError::Here)?;
        check_abscissae(scene, &plate).map_err(PlateError::Here)?;
        let files = [named].into_iter().chain(cloud.iter().map(|cloud| cloud.file().clone()));
        let parameters = scene.parameters.iter().map(|parameter| parameter.key.clone()).collect();
        let (name, files) = (name.clone(), files.collect());
        Ok(Self { name, keys, cloud, pointers, parameters, scene: plate, files })
    }

    /// The plate at a point of the parameters, with a seed.
    ///
    /// # Errors
    /// An [`Objection`] with the key of the plate that refuses the value.
    pub fn at(&self, point: &[f64], seed: u64) -> Result<PlateAt, Objection> {
        let mut keys = self.keys.clone();
        for (pointer, &value) in self.pointers.iter().zip(point) {
            if let Some(place) = keys.pointer_mut(pointer) {
                *place = json!(value);
            }
        }
        let scene = CrackScene::from_keys(&keys);
        let mut scene = scene
            .map_err(|wrong| Objection::new(wrong.path().to_string(), wrong.inner().to_string()))?;
        scene.ensemble.seed = seed;
        // Ensembles are as large as a register holds, whatever the plate alone would run.
        let lanes = scene.ensemble.precision.n_lanes();
        scene.ensemble.realisations = scene.ensemble.realisations.max(lanes);
        scene.check()?;
        let problem = CrackProblem::new(&scene, self.cloud.clone())?;
        Ok(PlateAt { scene, problem })
    }

    /// Rejects parameters between whose bounds the plate cannot be built: it is tried at all corners of their box.
    ///
    /// # Errors
    /// An [`Objection`] to the bound that the plate refuses.
    pub fn check_corners(&self, scene: &InferenceScene) -> Result<(), Objection> {
        let n = scene.parameters.len();
        for corner in 0..1_usize << n {
            let is_high = |i: usize| (corner >> i) & 1 == 1;
            let bounds = scene.parameters.iter().enumerate();
            let point: Vec<f64> =
                bounds.map(|(i, it)| if is_high(i) { it.high } else { it.low }).collect();
            self.at(&point, scene.seed).map_err(|objection| {
                let side = |i: usize| if is_high(i) { "high" } else { "low" };
                let refused = self.parameters.iter().position(|key| *key == objection.path);
                let path = refused.map_or_else(
                    || "parameters".to_owned(),
                    |i| format!("parameters[{i}].{}", side(i)),
                );
                self.objection(path, &point, &objection)
            })?;
        }
        Ok(())
    }

    /// The objection to a point of the parameters that the plate refuses.
    #[must_use]
    pub fn objection(&self, path: impl Into<String>, point: &[f64], of: &Objection) -> Objection {
        let Objection { path: key, message, help } = of;
        let at = if key.is_empty() { String::new() } else { format!(" at `{key}`") };
        let message = format!("{} refuses {}{at}: {message}", self.name, self.words(point));
        let objection = Objection::new(path, message);
        match help {
            Some(help) => objection.with_help(help),
            None => objection,
        }
    }

    /// Abscissae from the tip of the notch to the far edge, a spacing apart (m).
    #[must_use]
    pub fn abscissae(&self) -> Vec<f64> {
        let CrackScene { notch, body, .. } = &self.scene;
        let (low, high) = ahead(&self.scene);
        let forward = if notch.tip[0] >= notch.mouth[0] { body.spacing } else { -body.spacing };
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a column of a body, which has at most 2^31 of them"
        )]
        let n = ((high - low) / body.spacing).floor() as u32;
        (1..=n).map(|k| notch.tip[0] + forward * f64::from(k)).collect()
    }

    /// A point in words: `a = 1, b = 2`.
    #[must_use]
    pub fn words(&self, point: &[f64]) -> String {
        let one = |(key, value): (&String, &f64)| format!("{key} = {value}");
        self.parameters.iter().zip(point).map(one).collect::<Vec<_>>().join(", ")
    }
}

/// A number of a plate.
struct Number {
    /// As error messages write it, `notch.tip[0]`.
    key: String,
    /// `/notch/tip/0`.
    pointer: String,
    /// Whether it counts something.
    is_whole: bool,
}

/// All numbers of the plate, in the order of its keys.
fn numbers(keys: &Value) -> Vec<Number> {
    let (mut open, mut found) = (vec![(String::new(), String::new(), keys)], Vec::new());
    while let Some((key, pointer, value)) = open.pop() {
        match value {
            Value::Number(number) => {
                found.push(Number { key, pointer, is_whole: !number.is_f64() });
            }
            Value::Object(map) => {
                let inner = map
                    .iter()
                    .filter(|(name, _)| !(pointer.is_empty() && ASIDE.contains(&name.as_str())));
                open.extend(inner.rev().map(|(name, value)| {
                    let dot = if key.is_empty() { "" } else { "." };
                    (format!("{key}{dot}{name}"), format!("{pointer}/{name}"), value)
                }));
            }
            Value::Array(list) => {
                let inner = list.iter().enumerate().rev();
                open.extend(
                    inner
                        .map(|(i, value)| (format!("{key}[{i}]"), format!("{pointer}/{i}"), value)),
                );
            }
            _ => {}
        }
    }
    found
}

/// JSON pointers of the parameters.
fn pointers(scene: &InferenceScene, keys: &Value) -> Result<Vec<String>, Objection> {
    let numbers = numbers(keys);
    let of = |(i, key): (usize, &str)| {
        let path = format!("parameters[{i}].key");
        let Some(number) = numbers.iter().find(|number| number.key == key) else {
            let message = format!("{} has no number `{key}`", scene.plate);
            return Err(Objection::new(path, message).with_help(help(key, &numbers)));
        };
        if number.is_whole {
            let message = format!("`{key}` is a whole number; a parameter varies continuously");
            let objection = Objection::new(path, message);
            return Err(if key == "bonds.horizon.shells" {
                let help = "write the horizon of the plate as a length: { \"length\": ... }";
                objection.with_help(help)
            } else {
                objection
            });
        }
        Ok(number.pointer.clone())
    };
    scene.parameters.iter().map(|parameter| parameter.key.as_str()).enumerate().map(of).collect()
}

/// The nearest key, else those with the same last word, else all.
fn help(key: &str, numbers: &[Number]) -> String {
    let known: Vec<&str> =
        numbers.iter().filter(|it| !it.is_whole).map(|it| it.key.as_str()).collect();
    let last = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
    let alike: Vec<&str> = known.iter().copied().filter(|it| last(it) == last(key)).collect();
    let found = match nearest(key, known.iter().copied()) {
        Some(nearest) => vec![nearest],
        None if !alike.is_empty() => alike,
        None => return format!("its numbers are {}", quoted(&known)),
    };
    format!("did you mean {}?", quoted(&found))
}

fn quoted(keys: &[&str]) -> String {
    keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ")
}

/// Abscissae that a crack of the plate can come to, from the lowest to the highest (m).
fn ahead(plate: &CrackScene) -> (f64, f64) {
    let (tip, width) = (plate.notch.tip[0], plate.body.size[0]);
    if tip >= plate.notch.mouth[0] { (tip, width) } else { (0.0, tip) }
}

/// Rejects abscissae that no crack can come to.
fn check_abscissae(scene: &InferenceScene, plate: &CrackScene) -> Result<(), Objection> {
    let (low, high) = ahead(plate);
    for (i, &x) in scene.summaries.abscissae.iter().enumerate() {
        if !(x > low && x < high) {
            let message = format!("the abscissa {x} m is not ahead of the notch");
            let help = format!("cracks of {} grow between {low} m and {high} m", scene.plate);
            let path = format!("summaries.abscissae[{i}]");
            return Err(Objection::new(path, message).with_help(help));
        }
    }
    Ok(())
}
