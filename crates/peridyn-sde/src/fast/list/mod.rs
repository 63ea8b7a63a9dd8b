//! Bonds in a list: a bond in each lane of one realisation, or a realisation in each lane.
//!
//! The force of a bond is that of [`bond_force`](super::bond_force); the code here finds ends in memory and adds to them.

mod body;
mod columns;
mod crossing;
mod lanes;
mod rows;

pub use body::BondList;
