//! Scenes with known answers, by solver.

mod crack_inference;
mod density_methods;
mod estimators;
mod first_passages;
mod functions;
mod linear_systems;
mod peridyn_linear;
mod peridyn_weakest_link;
mod scalar_systems;
mod smpm_responses;
mod smpm_sweeps;
mod stationary_oscillators;

use crate::Family;

/// All families.
pub const ALL: &[Family] = &[
    linear_systems::FAMILY,
    scalar_systems::WELLS,
    scalar_systems::CLOSED,
    stationary_oscillators::FAMILY,
    first_passages::FAMILY,
    smpm_sweeps::FAMILY,
    smpm_responses::FAMILY,
    estimators::FAMILY,
    peridyn_linear::FAMILY,
    peridyn_weakest_link::FAMILY,
    crack_inference::FAMILY,
];
