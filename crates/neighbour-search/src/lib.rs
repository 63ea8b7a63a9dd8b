#![doc = include_str!("../README.md")]

mod brute_force;
mod cell_grid;
mod cells;
mod error;
mod list;
mod radii;
mod search;

pub use brute_force::BruteForce;
pub use cell_grid::CellGrid;
pub use error::Error;
pub use list::{NeighbourList, Pair};
pub use radii::{Criterion, MAX_RADIUS, MIN_RADIUS, Radii};
pub use search::NeighbourSearch;
