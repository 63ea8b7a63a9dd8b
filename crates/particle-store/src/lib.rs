#![doc = include_str!("../README.md")]

mod adapt;
mod bytes;
mod column;
mod error;
mod hash;
mod lattice;
mod morton;
mod paraview;
mod snapshot;
mod store;

pub use adapt::{Child, Rule, Rules};
pub use column::{Element, Handle, Kind, SymmetricTensor};
pub use error::Error;
pub use lattice::Lattice;
pub use morton::morton_order;
pub use paraview::write_pvd;
pub use store::{Attribute, ParticleStore};
