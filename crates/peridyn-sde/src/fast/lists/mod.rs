//! Bonds in a list: a bond in each lane of one realisation, or a realisation in each lane.
//!
//! The force of a bond is that of [`bond_force`](super::bond_force); what is here finds ends in memory and adds to them.

pub(super) mod list;
pub(super) mod list_body;
pub(super) mod list_columns;
pub(super) mod list_crossing;
pub(super) mod list_lanes;
pub(super) mod list_rows;
