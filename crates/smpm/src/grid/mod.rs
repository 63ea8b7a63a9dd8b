//! The background grid: nodes in tiles and blocks where particles are, the solution at the nodes, planes and contact.
//!
//! Nodes know masses, momenta and forces. They know nothing of materials, nor of which particle gave what.

pub(crate) mod background;
pub(crate) mod binning;
pub(crate) mod blocks;
pub(crate) mod boundary;
pub(crate) mod contact;
pub(crate) mod lattice;
pub(crate) mod node;
pub(crate) mod reactions;
pub(crate) mod surfaces;
pub(crate) mod tile_size;
pub(crate) mod tiles;
