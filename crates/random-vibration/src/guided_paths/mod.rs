//! Paths under guides, their weights, and the probabilities that follow.
//!
//! Nothing here knows how a guide is computed.

pub(crate) mod event;
pub(crate) mod free_passage;
pub(crate) mod guided;
pub(crate) mod guided_config;
pub(crate) mod guided_exceedance;
pub(crate) mod guided_passage;
pub(crate) mod guided_study;
pub(crate) mod path_runner;
pub(crate) mod pilots;
pub(crate) mod weights;
