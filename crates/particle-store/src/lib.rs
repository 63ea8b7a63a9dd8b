#![doc = include_str!("../README.md")]

mod adapt;
mod bytes;
mod column;
mod error;
mod kind;
mod lattice;
mod morton;
mod paraview;
mod rule;
mod snapshot;
mod store;
mod tensor;

pub use adapt::{Child, Rules};
pub use column::{Element, Handle};
pub use error::Error;
pub use kind::Kind;
pub use lattice::Lattice;
pub use morton::morton_order;
pub use paraview::write_pvd;
pub use rule::Rule;
pub use store::{Attribute, ParticleStore};
pub use tensor::SymmetricTensor;
