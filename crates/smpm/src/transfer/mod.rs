//! Shape functions, particle to grid (P2G) and grid to particle (G2P).
//!
//! `f64` is processed in groups of particles in registers, numbers with derivatives one particle at a time. No material is computed
//! here: stresses are read, velocity gradients written.

pub(crate) mod grid_to_group;
pub(crate) mod grid_to_jet;
pub(crate) mod group;
pub(crate) mod group_to_grid;
pub(crate) mod jet_to_grid;
pub(crate) mod particle_motion;
pub(crate) mod particle_terms;
pub(crate) mod shape;
pub(crate) mod taylor_weights;
pub(crate) mod transfers;
pub(crate) mod velocity_gradients;
