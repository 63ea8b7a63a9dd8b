//! Problems that charts and the proof share, with their references.

pub mod fpk;
pub mod peridyn;
pub mod sde;
pub mod smpm;
