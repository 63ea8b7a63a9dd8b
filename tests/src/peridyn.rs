//! Bodies of bonds: what the cases of `peridyn-sde` share.

pub mod first_passage;
pub mod network;
pub mod plate;
pub mod rest;
