//! Forces of bonds that break at a critical stretch, over wide registers.
//!
//! `bond_force` is the one text of a bond, pair or solid; lattices visit bonds along rows of nodes, lists one after the other. Nothing
//! here knows time, noise or loads.

mod bond_force;
mod lattice;
mod lattice_body;
mod lattice_grid;
mod lattice_rows;
mod limit;
mod lists;
mod realisations;
mod solids;
mod stencil;

pub use lattice::LatticeBody;
pub use lists::list::BondList;
pub use solids::solid_lattice::SolidLattice;
pub use solids::solid_list::SolidList;

/// In which lanes a bond is intact: a bit for each of at most [`MOST_LANES`](simd_lanes::MOST_LANES).
type LaneBits = u16;
