//! The density of an oscillator on a conservative grid.
//!
//! Nothing here knows paths.

pub(crate) mod discrete_gaussian;
pub(crate) mod grid;
pub(crate) mod grid_config;
pub(crate) mod remap;
