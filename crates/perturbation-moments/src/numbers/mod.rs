//! Numbers that carry derivatives, and what a model may do with them.
//!
//! Nothing here knows moments.

pub(crate) mod gradient;
pub(crate) mod jet;
pub(crate) mod real;
pub(crate) mod scalar;
