//! What only cases of `peridyn-sde` use.

pub mod plate;
pub mod rest;
