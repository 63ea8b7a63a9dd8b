//! Rare events of models of many normals: a design point, and lines through the samples beside it.
//!
//! Nothing here knows levels or designs.

pub(crate) mod line_crossing;
pub(crate) mod normal_model;
pub(crate) mod tail_design_point;
pub(crate) mod tail_sampling;
