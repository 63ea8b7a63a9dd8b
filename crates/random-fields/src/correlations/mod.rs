//! Correlation functions of a distance, and of a vector between two points.
//!
//! Nothing here knows a field.

pub(crate) mod correlation;
pub(crate) mod matern;
pub(crate) mod spatial_correlation;
