//! Explosions and impacts: what the cases, scenes and charts of `smpm` share.

pub mod experiment;
pub mod material_scene;
mod material_schema;
pub mod problems;
pub mod quantity_name;
pub mod reading;
mod region;
pub mod riemann;
pub mod scene;
pub mod schemes;
