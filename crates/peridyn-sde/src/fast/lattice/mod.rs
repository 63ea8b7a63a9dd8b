//! Bonds of a lattice: no list, a stencil and a bit for each bond.
//!
//! Bonds of one vector from neighbouring nodes are computed side by side, in bands of rows in parallel. The force of a bond is that of
//! [`bond_force`](super::bond_force); the code here finds ends in memory and adds to them.

mod band;
mod body;
mod grid;
mod rows;
mod stencil;

pub use body::LatticeBody;
