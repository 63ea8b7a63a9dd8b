//! The two kinds of bonds that have forces in wide registers.

use crate::bodies::bonds::Bonds;
use crate::solid::SolidBonds;

/// The bonds of a body and how they pull.
#[derive(Debug, Clone)]
pub(super) enum Potential {
    /// The tension of a bond depends on its own stretch.
    Pair(Bonds),
    /// The tension of a bond also depends on the dilatation at both of its ends.
    Solid(SolidBonds),
}

impl Potential {
    pub(super) fn bonds(&self) -> &Bonds {
        match self {
            Self::Pair(bonds) => bonds,
            Self::Solid(solid) => solid.bonds(),
        }
    }

    pub(super) fn solid(&self) -> Option<&SolidBonds> {
        match self {
            Self::Pair(_) => None,
            Self::Solid(solid) => Some(solid),
        }
    }
}
