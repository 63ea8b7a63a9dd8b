//! Whether a force evaluation looks for bonds at their strength.

use crate::bodies::body::AtStrength;
use crate::breaking::broken_bond::BrokenBond;

/// The relative squared elongation at which bonds count as at their strength.
#[derive(Debug, Clone, Copy)]
pub(super) enum Limit {
    /// That of their strength.
    Strength,
    /// None that is reached.
    Unreached,
}

impl Limit {
    /// That of an evaluation, and where it lists bonds; what it lists in `none` is of no use.
    pub(super) fn of<'a>(
        at: AtStrength<'a>,
        none: &'a mut Vec<BrokenBond>,
    ) -> (Self, &'a mut Vec<BrokenBond>) {
        match at {
            AtStrength::Break(list) => (Self::Strength, list),
            AtStrength::Hold => (Self::Unreached, none),
        }
    }
}
