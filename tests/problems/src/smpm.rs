//! Explosions and impacts, and the tables of the source.

pub mod problems;
pub mod published;
