//! What is claimed of `estimators`.

pub(crate) mod coverage;
pub(crate) mod multilevel;
pub(crate) mod plane_beam;
pub(crate) mod random_field_beam;
pub(crate) mod rare_events;
