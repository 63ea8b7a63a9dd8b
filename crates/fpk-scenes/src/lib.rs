//! Density scenes: scene types, their systems and methods, and their execution.

pub(crate) mod checks;
pub mod density;
pub mod integrator_scene;
pub mod lattice_scene;
pub mod law_scene;
pub mod method_scene;
pub mod monte_carlo;
pub mod paths;
pub mod plane_density;
pub mod run;
pub mod scene;
pub mod scheme_scene;
pub mod structure_scene;
pub mod system;
pub mod system_scene;
