#![doc = include_str!("../README.md")]

mod bodies;
pub mod experiment;
mod keys;
mod keyword_file;
pub mod materials;
mod numbers;
mod random_fields;
pub mod reading;
mod retired;
pub mod run;
pub mod sources;

pub(crate) use self::bodies::{point_list, region, surface};
pub(crate) use self::keys::{coordinates, material_part, material_units};
pub use self::keys::{
    keyword_file_scene, load_scene, material_scene, method_scene, quantity_name,
    random_field_scene, scene, sweep_scene,
};
