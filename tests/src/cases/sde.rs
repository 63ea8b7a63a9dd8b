//! What is claimed of the methods of `sde-integrators`.

pub(crate) mod explosion;
pub(crate) mod mean_square;
pub(crate) mod orders;
pub(crate) mod oscillator_bias;
pub(crate) mod oscillator_ensemble;
pub(crate) mod quartic;
