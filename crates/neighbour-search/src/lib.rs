#![doc = include_str!("../README.md")]
#![allow(
    clippy::inline_always,
    reason = "what a loop over lanes calls must be compiled within it, or it lacks its instructions"
)]

mod aligned;
mod brute_force;
mod candidates;
mod cell_grid;
mod cells;
mod compiled;
mod criterion;
mod domain;
mod error;
mod frame;
mod index;
mod leaf_tree;
mod leaves;
mod list;
mod near;
mod neighbourhood;
mod parallel;
mod query;
mod radii;
mod room;
mod row;
mod rows;
mod search;
mod skin_list;
mod sorted;

pub use brute_force::BruteForce;
pub use cell_grid::CellGrid;
pub use criterion::{Criterion, MAX_RADIUS, MIN_RADIUS};
pub use domain::Domain;
pub use error::Error;
pub use leaf_tree::LeafTree;
pub use list::{NeighbourList, Pair};
pub use near::Near;
pub use radii::Radii;
pub use row::Row;
pub use search::NeighbourSearch;
pub use skin_list::{SkinList, Update};
