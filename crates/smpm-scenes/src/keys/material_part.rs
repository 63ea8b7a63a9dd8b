//! Parts of a material, and its parameters by part and name.

use std::collections::BTreeMap;

/// Part of a material that a parameter belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MaterialPart {
    /// The equation of state.
    Equation,
    /// The strength.
    Strength,
    /// The damage.
    Damage,
}

impl MaterialPart {
    pub(super) const ALL: [(Self, &'static str); 3] =
        [(Self::Equation, "equation"), (Self::Strength, "strength"), (Self::Damage, "damage")];
}

/// Parameters of a material.
pub type Numbers = BTreeMap<(MaterialPart, &'static str), f64>;
