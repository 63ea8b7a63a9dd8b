//! Stability limits of `peridyn-sde`: strength over noise, and the horizon.

pub(crate) mod horizon;
pub(crate) mod noise;
