//! List of the materials that a scene may name.

use result_figures::number::tidy;
use smpm::material::Units;
use smpm::material::library::{ALL, Entry};

use crate::material_units::unit;

/// From where on a number has an exponent.
const LARGE: f64 = 1e6;

/// The materials of the library: a line with name, model and source, and one with the constants in SI.
#[must_use]
pub fn text() -> String {
    let mut all: Vec<&Entry> = ALL.iter().collect();
    all.sort_by_key(|entry| entry.name);
    let of = |Entry { model, name, source, parameters }: &Entry| {
        let number = |value| if value < LARGE { tidy(value) } else { format!("{value:e}") };
        let constant = |(name, value)| format!("{name} {} {}", number(value), unit(name).0);
        let constants = parameters(Units::SI).into_iter().map(constant);
        let constants: Vec<String> = constants.map(|it| it.trim_end().to_owned()).collect();
        format!("{name}, {model}: {source}\n    {}\n", constants.join(", "))
    };
    all.into_iter().map(of).collect()
}
