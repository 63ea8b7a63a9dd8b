//! What only cases of `peridyn-sde` use.

pub mod concrete;
pub mod plate;
