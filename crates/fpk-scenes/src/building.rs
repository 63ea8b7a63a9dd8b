//! Scenes of a shear building: first passages of the drifts of its storeys.

mod building_scene;
mod method_scene;
pub mod run;
pub mod scene;
mod step_bias;

pub use self::building_scene::{
    BuildingScene, DampingScene, GroundScene, HysteresisScene, SoilScene,
};
pub use self::method_scene::BuildingMethod;
