#![doc = include_str!("../README.md")]

mod coordinates;
pub mod experiment;
mod geometry;
mod grids;
mod material_library;
pub mod material_scene;
mod material_schema;
pub mod method_scene;
mod polygon;
pub mod quantity_name;
pub mod random_field_scene;
mod random_fields;
pub mod reading;
mod region;
mod retired;
pub mod run;
pub mod scene;
pub mod sources;
mod unknown_name;
mod varying_body;
