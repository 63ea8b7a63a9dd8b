//! What is claimed of `smpm`.

pub(crate) mod contact_explosion;
pub(crate) mod detonation;
pub(crate) mod disks;
pub(crate) mod edges;
pub(crate) mod elastic_bar;
mod incline;
mod methods;
pub(crate) mod multilevel;
pub(crate) mod paper_size;
pub(crate) mod plate_impact;
pub(crate) mod published_tables;
pub(crate) mod random_fields;
pub(crate) mod random_slope;
pub(crate) mod refinement;
pub(crate) mod shock_tubes;
pub(crate) mod sobol_points;
pub(crate) mod taylor_bar;
pub(crate) mod trust;
pub(crate) mod variance_fields;
