//! Forces of bonds that break at a critical stretch, over wide registers.

mod bond_force;
mod lattice;
mod lattice_body;
mod lattice_grid;
mod lattice_rows;
mod limit;
mod list;
mod list_body;
mod list_columns;
mod list_crossing;
mod list_lanes;
mod list_rows;
mod realisations;
mod solid_lanes;
mod solid_lattice;
mod solid_lattice_body;
mod solid_list;
mod solid_list_body;
mod solid_list_rows;
mod solid_rows;
mod stencil;

pub use lattice::LatticeBody;
pub use list::BondList;
pub use solid_lattice::SolidLattice;
pub use solid_list::SolidList;

/// In which lanes a bond is intact: a bit for each of at most [`MOST_LANES`](simd_lanes::MOST_LANES).
type LaneBits = u16;
