//! Objections to numbers of a scene that must be positive.

use scene_runs::scene::Objection;

/// An objection to a number that is not greater than zero.
pub(crate) fn positive(path: &str, name: &str, value: f64) -> Result<(), Objection> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Objection::new(path, format!("{name} is {value}; it must be greater than 0")))
}
