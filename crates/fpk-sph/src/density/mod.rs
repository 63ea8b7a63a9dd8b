//! The density between and beyond the particles: cells of the deformed lattice, integrals over them, and the density at any
//! point.
//!
//! All follows from one evaluation of the solver. Nothing here steps, and nothing knows the system or its simulation.

mod cell;
pub(crate) mod cell_integral;
pub(crate) mod density_field;
pub(crate) mod probability;
