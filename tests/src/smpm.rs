//! Explosions and impacts: what the cases, scenes and charts of `smpm` share.

pub mod experiment;
pub mod material_scene;
pub mod reading;
mod region;
pub mod scene;
