//! The linear peridynamic solid in lists and on lattices: two passes over bonds, for the dilatation of nodes and for the forces.
//!
//! Elongations and pulls are those of [`bond_force`](super::bond_force), places in memory those of the lists and lattices of bonds.

pub(super) mod solid_lanes;
pub(super) mod solid_lattice;
pub(super) mod solid_lattice_body;
pub(super) mod solid_list;
pub(super) mod solid_list_body;
pub(super) mod solid_list_rows;
pub(super) mod solid_rows;
