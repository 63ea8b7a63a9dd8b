#![doc = include_str!("../README.md")]

mod cholesky;
mod discrete_gaussian;
mod grid;
mod grid_config;
mod linearisation;
mod normal_tail;
mod remap;
mod tail;

pub use grid::GridDensity;
pub use grid_config::{GridConfig, GridError};
pub use linearisation::{GaussianLaw, Linearisation, LinearisationError, Quadrature};
pub use normal_tail::upper_tail;
pub use sde_integrators::{Estimate, SubsetConfig, Uncertainty};
pub use tail::{TailError, TailPaths, Tails};
