//! A load on the surface of a body, as written in the JSON file of a scene.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::SurfaceLoad;

use super::coordinates::point;

/// A pressure or a traction on a part of the surface of a body, per area of the start and in directions of the start.
///
/// The surface is that of the boxes of the particles, which on a curved or inclined shape is steps: the forces by a pressure add up to the
/// right one, a traction acts on the area of the steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadScene {
    /// Lowest and highest corner of a region (length of `units`). Faces whose centres are in it at the start bear the load.
    pub within: [Vec<f64>; 2],
    /// Pressure, positive into the body (stress of `units`).
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(example = 0.1)]
    pub pressure: f64,
    /// Force per area along each axis (stress of `units`); none without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![0.0, -0.1])]
    pub traction: Vec<f64>,
    /// The multiple of both over time, as points of time (time of `units`) and multiple in ascending order; 1 without this key.
    ///
    /// It is linear between points, and constant before the first and after the last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![[0.0, 0.0], [2.0, 1.0]])]
    pub history: Vec<[f64; 2]>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl LoadScene {
    /// On the upper end of a column, as the schema shows it.
    pub(super) fn on_top() -> Self {
        let within = [vec![0.0, 1.0], vec![0.5, 1.0]];
        Self { within, pressure: 0.1, traction: vec![], history: vec![] }
    }

    /// The load.
    ///
    /// # Errors
    /// An [`Objection`] to a point of another dimension, to times that do not ascend, and to a load that is none.
    pub(crate) fn load<const D: usize>(&self, path: &str) -> Result<SurfaceLoad<D>, Objection> {
        check_history(&self.history, &format!("{path}.history"))?;
        let corner = |end: usize| point(&self.within[end], &format!("{path}.within[{end}]"));
        let traction = match self.traction.as_slice() {
            [] => [0.0; D],
            given => point(given, &format!("{path}.traction"))?,
        };
        if [self.pressure].iter().chain(&traction).all(|&of| of == 0.0) {
            return Err(Objection::new(path, "the load is zero")
                .with_help("write `pressure` or `traction`"));
        }
        let (within, history) = ([corner(0)?, corner(1)?], self.history.clone());
        Ok(SurfaceLoad { within, pressure: self.pressure, traction, history })
    }
}

/// The loads of a body, whose path is `path`.
///
/// # Errors
/// Those of each load; loads on a rigid body.
pub(crate) fn loads_of<const D: usize>(
    loads: &[LoadScene],
    is_rigid: bool,
    path: &str,
) -> Result<Vec<SurfaceLoad<D>>, Objection> {
    let path = format!("{path}.loads");
    if is_rigid && !loads.is_empty() {
        let message = "a rigid body keeps its velocity; no load acts on it";
        return Err(Objection::new(path, message).with_help("leave out `rigid` or `loads`"));
    }
    let load = |(i, load): (usize, &LoadScene)| load.load(&format!("{path}[{i}]"));
    loads.iter().enumerate().map(load).collect()
}

/// Rejects points of time that do not ascend.
pub(crate) fn check_history(history: &[[f64; 2]], path: &str) -> Result<(), Objection> {
    let mut from = 0.0;
    for (i, [time, _]) in history.iter().enumerate() {
        if time.is_nan() || *time < from {
            let message = format!("the time is {time} and must not be less than {from}");
            return Err(Objection::new(format!("{path}[{i}]"), message));
        }
        from = *time;
    }
    Ok(())
}
