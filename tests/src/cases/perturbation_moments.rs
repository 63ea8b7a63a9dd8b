//! What is claimed of `perturbation-moments`.

pub(crate) mod judge;
pub(crate) mod reference;
pub(crate) mod trust;
