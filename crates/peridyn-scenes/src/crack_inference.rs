//! Inference scenes: parameters of a crack scene from measured crack paths and failure loads.

pub mod measured;
pub mod plate;
pub mod run;
pub mod scene;
