//! Choices of method and model: trial runs of a scene by other methods and sizes, or without one of its ingredients.
//!
//! How a method works is not known here, only its name, size and scene.

pub mod advise;
pub mod ladder;
pub mod models;
