//! What is claimed of `peridyn-sde`.
