//! What only cases of `peridyn-sde` use.

pub(crate) mod concrete;
pub(crate) mod plate;
