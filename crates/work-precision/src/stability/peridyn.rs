//! Stability limits of `peridyn-sde`: step, strength over noise, and horizon.

pub(crate) mod horizon;
pub(crate) mod noise;
pub(crate) mod z;
