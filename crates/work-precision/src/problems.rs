//! Problems that charts and maps alone solve, with their references and their work.
//!
//! What the proof solves too is in `reference-problems`. Nothing here knows a chart.

pub(crate) mod exceedance_surface;
pub(crate) mod shock;
pub(crate) mod work;
