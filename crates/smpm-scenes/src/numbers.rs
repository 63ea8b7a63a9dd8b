//! Numbers of a scene, beside the constants of its materials, that may be random or swept, each by its path.

use scene_runs::scene::Objection;
use serde_json::Value;
use smpm::Fill;

use crate::method_scene::MethodScene;
use crate::region::BodyRegion;
use crate::scene::{BodyScene, SmpmScene, SolidScene};

/// Keys of a scene below which numbers may vary; the grid, times and gauges are the same in all runs.
const ROOTS: [&str; 4] = ["bodies", "boundaries", "contact", "gravity"];

/// A number at a path.
pub(crate) type NumberAt<'a> = (&'a str, f64);

/// Whether a name is the path of a number rather than a constant of a material.
pub(crate) fn is_path(name: &str) -> bool {
    ROOTS.iter().any(|root| {
        name.strip_prefix(root).is_some_and(|rest| rest.starts_with(['[', '.']) || rest.is_empty())
    })
}

/// A path as messages write it, `bodies[0].velocity[1]`, as a JSON pointer.
fn pointer(path: &str) -> String {
    format!("/{}", path.replace(']', "").replace(['[', '.'], "/"))
}

impl SmpmScene {
    /// The number at a path.
    ///
    /// # Errors
    /// An [`Objection`] by the key `key` to a path without a number that may vary.
    pub(crate) fn number(&self, path: &str, key: &str) -> Result<f64, Objection> {
        let scene = serde_json::to_value(self).unwrap_or_default();
        let found = scene.pointer(&pointer(path)).filter(|_| is_path(path));
        // A whole number, such as that of an axis, is written without a point.
        let Some(number) = found.filter(|it| it.is_f64()).and_then(Value::as_f64) else {
            let mut known = Vec::new();
            let root = |root: &str| scene.get(root).map(|value| (root.to_owned(), value.clone()));
            ROOTS
                .into_iter()
                .filter_map(root)
                .for_each(|(root, value)| list(root, &value, &mut known));
            return Err(Objection::unknown(key, "number", path, known.iter()));
        };
        if let Some((number, body)) = self.moved_body(path)
            && !body.has_movable_particles(path == format!("bodies[{number}].rotation.degrees"))
        {
            let message = format!("`{path}` of body `{}` cannot vary", body.name);
            let help = "sizes of boxes, balls and cylinders without `except` and `rotation` may, and `rotation.degrees`, of bodies without `loads`";
            return Err(Objection::new(key, message).with_help(help));
        }
        Ok(number)
    }

    /// The scene with other numbers at paths.
    ///
    /// # Errors
    /// An [`Objection`] to a path without a number, and to a scene that cannot be.
    pub(crate) fn with_numbers(&self, numbers: &[NumberAt<'_>]) -> Result<Self, Objection> {
        let wrong = |path: &str, what: String| Objection::new(path, what);
        let mut scene = serde_json::to_value(self).map_err(|error| wrong("", error.to_string()))?;
        for &(path, value) in numbers {
            let place = scene.pointer_mut(&pointer(path));
            let place = place.ok_or_else(|| wrong(path, "there is no such number".to_owned()))?;
            if !value.is_finite() {
                return Err(wrong(path, format!("the number is {value} and must be finite")));
            }
            *place = value.into();
        }
        let scene = serde_json::from_value::<Self>(scene);
        let mut scene = scene.map_err(|error| wrong("", error.to_string()))?;
        // What was read from files is no key.
        scene.materials.clone_from(&self.materials);
        for (body, own) in scene.bodies.iter_mut().zip(&self.bodies) {
            if !own.has_movable_particles(false) {
                body.shape.clone_from(&own.shape);
                body.except.clone_from(&own.except);
            }
        }
        Ok(scene)
    }

    /// The body of whose size or rotation a path is.
    pub(crate) fn moved_body(&self, path: &str) -> Option<(usize, &BodyScene)> {
        let (number, key) = path.strip_prefix("bodies[")?.split_once("].")?;
        let moves = ["shape", "except", "rotation"].iter().any(|part| key.starts_with(part));
        let number = number.parse().ok().filter(|_| moves)?;
        self.bodies.get(number).map(|body| (number, body))
    }

    /// Unit of the number at a path; empty where it has none.
    pub(crate) fn unit_at(&self, path: &str) -> &'static str {
        let [length, _, stress, _, velocity] = self.units.names();
        match () {
            () if path.ends_with("].pressure") || path.contains("].traction[") => stress,
            () if path.ends_with("].rotation.degrees") => "degrees",
            () if self.moved_body(path).is_some() => length,
            () if path.contains("].velocity[") => velocity,
            () => "",
        }
    }
}

impl BodyScene {
    /// Whether its particles can turn with its rotation, or else be stretched with its size.
    fn has_movable_particles(&self, is_turned: bool) -> bool {
        let is_simple = matches!(
            self.shape,
            SolidScene::Box { .. } | SolidScene::Ball { .. } | SolidScene::Cylinder { .. }
        );
        let is_whole = is_simple && self.except.is_empty() && self.rotation.is_none();
        self.loads.is_empty() && (is_turned || is_whole)
    }
}

/// The particles of a body after a change of its size or rotation: as many as before, so that responses are continuous. A box is filled
/// whole.
pub(crate) fn moved<const D: usize>(
    fill: &Fill<D>,
    before: &BodyRegion<D>,
    after: &BodyRegion<D>,
) -> Fill<D> {
    if let Some(turn) = before.turn(after) {
        return Fill { positions: fill.positions.iter().map(turn).collect(), ..*fill };
    }
    let ((low, high), (new_low, new_high)) = (before.filled(fill), after.bounds());
    let factor: [f64; D] = std::array::from_fn(|k| (new_high[k] - new_low[k]) / (high[k] - low[k]));
    let place = |x: &[f64; D]| std::array::from_fn(|k| new_low[k] + (x[k] - low[k]) * factor[k]);
    Fill {
        positions: fill.positions.iter().map(place).collect(),
        spacing: std::array::from_fn(|k| fill.spacing[k] * factor[k]),
    }
}

/// The paths of all numbers of a value.
fn list(path: String, value: &Value, into: &mut Vec<String>) {
    match value {
        Value::Array(items) => {
            let each = items.iter().enumerate();
            each.for_each(|(i, item)| list(format!("{path}[{i}]"), item, into));
        }
        Value::Object(keys) => {
            keys.iter().for_each(|(key, item)| list(format!("{path}.{key}"), item, into));
        }
        Value::Number(number) if number.is_f64() => into.push(path),
        _ => {}
    }
}

impl SmpmScene {
    /// Rejects a sweep over no number or of no event, and methods that it does not take.
    pub(crate) fn check_sweep(&self) -> Result<(), Objection> {
        let Some(sweep) = &self.sweep else { return Ok(()) };
        sweep.check()?;
        self.number(&sweep.number, "sweep.number")?;
        let (path, event) = ("sweep.event", &sweep.event);
        if self.gauges.iter().all(|gauge| gauge.name != event.gauge) {
            let names = self.gauges.iter().map(|gauge| &gauge.name);
            return Err(Objection::unknown(format!("{path}.gauge"), "gauge", &event.gauge, names));
        }
        if !self.quantities.contains(&event.quantity) {
            let names = self.quantities.iter();
            let path = format!("{path}.quantity");
            return Err(Objection::unknown(path, "quantity", &event.quantity, names));
        }
        let help =
            "take `deterministic`, or `monte_carlo` with `control` false and `random` parameters";
        let message = match self.method {
            MethodScene::MonteCarlo { control: true, .. } => Some("a sweep has no control variate"),
            MethodScene::MonteCarlo { .. } if self.random.is_empty() => {
                Some("there are no random parameters to sample")
            }
            MethodScene::Deterministic | MethodScene::MonteCarlo { .. } => None,
            _ => Some("this method does not go with `sweep`"),
        };
        message.map_or(Ok(()), |it| Err(Objection::new("method", it).with_help(help)))?;
        if self.levels.is_empty() && self.random_fields.is_empty() && !self.fields {
            return Ok(());
        }
        let message = "a sweep goes without `levels`, `random_fields` and `fields`";
        Err(Objection::new("sweep", message)
            .with_help("leave them out; `event` has the level of a sweep"))
    }
}
