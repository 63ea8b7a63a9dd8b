#![doc = include_str!("../README.md")]
#![allow(
    clippy::inline_always,
    reason = "what a loop over lanes calls must be compiled within it, or it lacks its instructions"
)]

mod brute_force;
mod cell_grid;
mod cells;
mod error;
mod list;
mod query;
mod radii;
mod search;
mod simd;
mod skin_list;

pub use brute_force::BruteForce;
pub use cell_grid::CellGrid;
pub use error::Error;
pub use list::{NeighbourList, Pair};
pub use query::Near;
pub use radii::{Criterion, MAX_RADIUS, MIN_RADIUS, Radii};
pub use search::NeighbourSearch;
pub use skin_list::{SkinList, Update};
