//! What is claimed of `peridyn-sde`.

pub(crate) mod branching;
pub(crate) mod breaking;
pub(crate) mod concrete;
pub(crate) mod equilibrium;
pub(crate) mod horizon_inference;
pub(crate) mod infer_scene;
pub(crate) mod inference;
pub(crate) mod kalthoff_winkler;
pub(crate) mod lattice_locking;
pub(crate) mod nonlinear_equilibrium;
pub(crate) mod notched_plate;
pub(crate) mod one_bond;
pub(crate) mod precracked_block;
pub(crate) mod quasi_static;
pub(crate) mod slow_scenes;
pub(crate) mod two_notches;
mod weibull_posterior;
pub(crate) mod weibull_strength;
