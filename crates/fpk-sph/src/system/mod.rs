//! The system whose density is carried, as the method calls it: coefficients over blocks of particles, and a linear filter
//! in front of a structure.
//!
//! This folder knows the functions of a system and the moments of a filter. It knows no cloud's neighbours, no estimator and
//! no step.

pub(crate) mod coefficients;
pub(crate) mod linear_filter;
