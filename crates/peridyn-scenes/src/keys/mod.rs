//! Keys of a crack scene: their types, units and checks.
//!
//! Types are as the JSON is written. They know no run, file or answer, and no body that is built of them.

pub(crate) mod named;
pub(crate) mod positive;
pub mod scene;
pub mod scene_body;
pub(crate) mod scene_check;
pub mod scene_dynamics;
pub mod scene_field;
pub mod scene_load;
