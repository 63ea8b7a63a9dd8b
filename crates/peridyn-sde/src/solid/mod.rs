//! The linear peridynamic solid: bonds whose tension depends on the dilatation at both of their ends.

mod bonds;
mod criterion;
mod energy;
mod moduli;
mod network;
mod surface;

pub use bonds::SolidBonds;
pub use criterion::{critical_bond_energy, critical_stretch_of_solid};
pub(crate) use energy::energy;
pub use network::{BondFailure, SolidNetwork};
