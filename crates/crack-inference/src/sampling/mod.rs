//! The posterior: a tempered cloud, chains from its points, and their diagnostics.
//!
//! The likelihood is a function of the parameters; nothing here knows how it is computed.

pub(crate) mod diagnostics;
pub(crate) mod posterior;
pub(crate) mod sampler_config;
mod target;
mod tempered;
