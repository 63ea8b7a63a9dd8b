//! Objection to a name that the scene does not have.

use scene_runs::nearest::nearest;
use scene_runs::scene::Objection;

/// The objection, with the nearest of the known names.
pub(crate) fn unknown<'a>(
    path: &str,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a String>,
) -> Objection {
    let known: Vec<&str> = known.map(String::as_str).collect();
    let hint = match nearest(name, known.iter().copied()) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("available: {}", known.join(", ")),
    };
    Objection::new(path, format!("there is no {what} `{name}`")).with_help(hint)
}
