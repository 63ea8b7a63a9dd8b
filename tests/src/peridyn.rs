//! Bodies of bonds: what the cases of `peridyn-sde` share.

pub mod plate;
pub mod rest;
