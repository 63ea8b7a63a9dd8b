#![doc = include_str!("../README.md")]

pub mod building;
pub mod density;
mod keys;
mod kinks;
pub mod monte_carlo;
pub mod paths;
pub mod plane_density;
mod retired;
pub mod run;
pub mod sources;
pub mod system;

pub(crate) use self::keys::checks;
pub use self::keys::{lattice_scene, law_scene, method_scene, scene, scheme_scene, system_scene};
