//! Problems that charts and the proof share, with their references and the methods that scenes do not offer.

pub mod fpk;
pub mod peridyn;
pub mod sde;
pub mod smpm;
