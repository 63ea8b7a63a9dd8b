//! Forces of bonds that break at a critical stretch, over wide registers.

mod lattice;
mod lattice_rows;
mod list;
mod list_lanes;
mod list_near;
mod list_rows;
mod pull;
mod stencil;
mod strain;
pub(crate) mod vectors;

pub use lattice::LatticeBody;
pub use list::BondList;
pub use strain::Strain;
