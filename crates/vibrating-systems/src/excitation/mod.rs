//! Excitation: its window in time, and the filters of the ground that shape it.
//!
//! Nothing here knows a particular structure.

pub(crate) mod filter;
pub(crate) mod filtered;
pub(crate) mod window;
