//! Checks of the numbers and lists of a scene.

use result_figures::number::exact;
use scene_runs::scene::Objection;

pub(crate) fn check_length(path: &str, count: usize, states: &[&str]) -> Result<(), Objection> {
    if count == states.len() {
        return Ok(());
    }
    let message = format!("there are {count} entries; the system has {} states", states.len());
    Err(Objection::new(path, message).with_help(format!("the states are {}", states.join(", "))))
}

/// Returns an objection to the value at a path unless it is valid.
pub(crate) fn must(path: &str, value: f64, holds: bool, limit: &str) -> Result<(), Objection> {
    if holds {
        Ok(())
    } else {
        Err(Objection::new(path, format!("{} was given; it must be {limit}", exact(value))))
    }
}
