//! Coordinates of a scene, checked against its dimension.

use scene_runs::scene::Objection;

/// A point of the right dimension.
pub(crate) fn point<const D: usize>(given: &[f64], path: &str) -> Result<[f64; D], Objection> {
    given.try_into().map_err(|_| {
        let message = format!("{} coordinates; the scene has {D} dimensions", given.len());
        Objection::new(path, message)
    })
}
