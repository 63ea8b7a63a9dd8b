//! Modes of the Karhunen-Loeve expansion, analytic on boxes and from pivots elsewhere, and where it is cut.
//!
//! Nothing here draws a number.

pub(crate) mod box_modes;
pub(crate) mod exponential_modes;
pub(crate) mod pivot_modes;
pub(crate) mod truncation;
