//! Keys of a density scene: their types, units and checks.
//!
//! Types are as the JSON is written; each builds what the solver takes. They know no run, file or answer.

pub(crate) mod checks;
pub mod lattice_scene;
pub mod law_scene;
pub mod method_scene;
pub mod scene;
pub mod scheme_scene;
pub mod system_scene;
