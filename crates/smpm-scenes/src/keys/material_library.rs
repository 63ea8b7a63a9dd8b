//! The entries of the material library of `smpm`, by model and name.

use smpm::material::{Units, library};

/// Parameters of an entry, by name.
pub(crate) type Entry = Vec<(&'static str, f64)>;

/// Entries of the library; each has some of the models.
pub(crate) const ENTRIES: [&str; 6] =
    ["steel", "steel_as_published", "copper", "aluminium", "water", "tnt"];

macro_rules! entry {
    ($parameters:expr) => {{
        let mut entry = Vec::new();
        let _ = $parameters.map(|name, value: f64| entry.push((name, value)));
        Some(entry)
    }};
}

/// Parameters of a model, by its key in a scene, if the library has them under this name.
pub(crate) fn entry(model: &str, name: &str, units: Units) -> Option<Entry> {
    match (model, name) {
        ("mie_gruneisen", "steel") => entry!(library::steel_equation(units)),
        ("mie_gruneisen", "copper") => entry!(library::copper_equation(units)),
        ("mie_gruneisen", "aluminium") => entry!(library::aluminium_equation(units)),
        ("mie_gruneisen", "water") => entry!(library::water(units)),
        ("jwl", "tnt") => entry!(library::tnt(units)),
        ("von_mises", "copper") => entry!(library::copper_linear_hardening(units)),
        ("johnson_cook", "steel") => entry!(library::steel_strength(units)),
        ("johnson_cook", "steel_as_published") => {
            entry!(library::steel_strength_as_published(units))
        }
        ("johnson_cook", "copper") => entry!(library::copper_strength(units)),
        ("damage", "steel") => entry!(library::steel_damage(units)),
        _ => None,
    }
}
