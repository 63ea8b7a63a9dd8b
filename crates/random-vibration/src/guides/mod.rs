//! Guides: the linearised system along its running law, and the backward functions that push paths towards an event.
//!
//! Nothing here runs a path.

pub(crate) mod adjoints;
pub(crate) mod backward;
pub(crate) mod pairwise_regression;
pub(crate) mod regression;
pub(crate) mod small_regression;
