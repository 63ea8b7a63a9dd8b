//! Bodies of a scene: their regions, filled with particles, and the grids below them.
//!
//! Regions and materials are as the scene states them. No run or answer is known here.

mod files;
pub(crate) mod geometry;
pub(crate) mod grids;
pub(crate) mod point_list;
pub(crate) mod polygon;
pub(crate) mod region;
mod rotation;
pub(crate) mod surface;
