//! Forces of bonds that break at a critical stretch, over wide registers, for pair potentials and for the linear peridynamic solid.
//!
//! `bond_force` is the only text of both forces. Two orders of visiting add them up: `lattice` goes along rows of nodes, `list` from
//! bond to bond. Nothing here knows time, noise or loads.

mod bond_force;
mod lattice;
mod list;
mod potential;

pub use lattice::LatticeBody;
pub use list::BondList;

use crate::bodies::body::AtStrength;
use crate::breaking::broken_bond::BrokenBond;

/// In which lanes a bond is intact: a bit for each of at most [`MOST_LANES`](simd_lanes::MOST_LANES).
type LaneBits = u16;

/// Whether an evaluation looks for bonds at their strength, and where it lists them; what is listed in `none` has no use.
fn list_of<'a>(
    at: AtStrength<'a>,
    none: &'a mut Vec<BrokenBond>,
) -> (bool, &'a mut Vec<BrokenBond>) {
    match at {
        AtStrength::Break(list) => (true, list),
        AtStrength::Hold => (false, none),
    }
}
