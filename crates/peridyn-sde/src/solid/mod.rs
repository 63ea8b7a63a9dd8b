//! The linear peridynamic solid: bonds whose tension depends on the dilatation at both of their ends.

mod bonds;
mod criterion;
mod energy;
mod moduli;
mod surface;

pub use bonds::SolidBonds;
pub use criterion::critical_stretch_of_solid;
