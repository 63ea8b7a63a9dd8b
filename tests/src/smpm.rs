//! Explosions and impacts: what the cases, scenes and charts of `smpm` share.

pub mod experiment;
pub mod material_scene;
pub mod problems;
pub mod reading;
mod region;
pub mod riemann;
pub mod scene;
pub mod schemes;
