//! Samples on several grids: a run on one of them, the estimate over all, and its record.
//!
//! Nothing here knows how answers are written.

pub(super) mod grid_level;
pub(super) mod multilevel;
pub(super) mod multilevel_record;
