//! Problems that charts and maps alone solve, with their references and their work.
//!
//! What the proof solves too is in `reference-problems`. Nothing here knows a chart.

pub mod exceedance_surface;
pub mod lattice;
pub mod oscillator_limits;
pub mod schemes;
pub mod work;
