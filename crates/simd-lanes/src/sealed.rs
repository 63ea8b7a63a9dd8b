//! Prevents implementations of the number, register and mask traits outside this crate.

/// Supertrait that only this crate implements.
pub trait Sealed {}
