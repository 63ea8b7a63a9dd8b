//! Random numbers: streams of a counter-based generator, normal numbers from them, increments of Brownian paths one by one or in
//! lanes, and factors that correlate them.
//!
//! Nothing here knows an equation, a method or an ensemble.

pub(crate) mod chacha;
pub(crate) mod cholesky;
pub(crate) mod components;
pub(crate) mod dense_factor;
pub(crate) mod lane_increments;
pub(crate) mod lane_normals;
pub(crate) mod noise_factor;
pub(crate) mod normal;
pub(crate) mod normal_distribution;
pub(crate) mod streams;
