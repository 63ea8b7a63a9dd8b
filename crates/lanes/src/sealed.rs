//! Numbers, registers and masks are those of this crate.

/// Implemented in this crate alone.
pub trait Sealed {}
