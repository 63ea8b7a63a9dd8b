//! Scenes of explosions and impacts: their types and their execution.

mod coordinates;
pub mod experiment;
mod geometry;
mod grids;
pub mod material_scene;
mod material_schema;
pub mod method_scene;
mod polygon;
pub mod quantity_name;
pub mod random_field_scene;
mod random_fields;
pub mod reading;
mod region;
pub mod run;
pub mod scene;
mod unknown_name;
