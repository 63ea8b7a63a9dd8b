//! Forces of bonds that break at a critical stretch, over wide registers.

mod bond_force;
mod lattice;
mod lattice_body;
mod lattice_rows;
mod limit;
mod list;
mod list_body;
mod list_columns;
mod list_crossing;
mod list_lanes;
mod list_rows;
mod stencil;
pub(crate) mod vectors;

pub use lattice::LatticeBody;
pub use list::BondList;
