//! Explosions and impacts, and the table of schemes.

pub mod problems;
pub mod published;
pub mod schemes;
