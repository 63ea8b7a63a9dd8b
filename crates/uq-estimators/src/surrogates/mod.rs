//! Cheaper models that take variance out of samples: given ones, and polynomials fitted to the same samples.
//!
//! Nothing here runs a model.

pub(crate) mod control;
pub(crate) mod hermite;
pub(crate) mod normal_equations;
pub(crate) mod polynomial;
