//! Multilevel Monte Carlo: samples over a ladder of models, in blocks that a tolerance asks for.
//!
//! Nothing here knows what a model computes.

pub(crate) mod blocks;
pub(crate) mod multilevel;
pub(crate) mod multilevel_result;
pub(crate) mod path_ladder;
pub(crate) mod statistic;
pub(crate) mod survey;
