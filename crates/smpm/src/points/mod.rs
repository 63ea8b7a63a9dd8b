//! Bodies: what their particles carry, and the update of their materials batch by batch.
//!
//! Materials are those of the crate constitutive-models. Nodes are reached through the transfer alone.

pub(crate) mod body;
pub(crate) mod compiled_points;
pub(crate) mod conditions;
pub(crate) mod fill;
pub(crate) mod material_points;
pub(crate) mod particle_pass;
pub(crate) mod particles;
pub(crate) mod points_in_lanes;
pub(crate) mod summary;
pub(crate) mod surface_load;
