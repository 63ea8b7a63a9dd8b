//! What is claimed of `estimators`.

pub(crate) mod coverage;
pub(crate) mod multilevel;
pub(crate) mod sensitivity;
