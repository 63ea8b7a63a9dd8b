//! Keys of a scene of bodies: their types, units and checks.
//!
//! Types are as the JSON is written. They know no run, file or answer.

pub(crate) mod coordinates;
pub mod keyword_file_scene;
pub mod load_scene;
pub(crate) mod material_origin;
pub(crate) mod material_part;
pub mod material_scene;
pub(crate) mod material_schema;
pub(crate) mod material_units;
pub mod method_scene;
pub(crate) mod plausible;
pub mod quantity_name;
pub mod random_field_scene;
pub mod scene;
pub mod sweep_scene;
pub(crate) mod units_scene;
