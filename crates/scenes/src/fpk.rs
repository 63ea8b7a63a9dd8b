//! Density scenes: their types, the systems and methods that they name, and how they are run.

pub mod density;
pub mod lattice_scene;
pub mod law_scene;
pub mod method_scene;
pub mod monte_carlo;
pub mod paths;
pub mod plane_density;
pub mod run;
pub mod scene;
mod scene_examples;
pub mod scene_system;
pub mod scheme_scene;
pub mod structure_scene;
pub mod system_scene;
