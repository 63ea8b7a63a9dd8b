#![doc = include_str!("../README.md")]

mod backward;
mod cholesky;
mod discrete_gaussian;
mod event;
mod grid;
mod grid_config;
mod guided;
mod guided_passage;
mod linearisation;
mod normal_tail;
mod pairwise_regression;
mod regression;
mod remap;
mod small_regression;
mod subset_passage;
mod tail;
mod weights;

pub use grid::GridDensity;
pub use grid_config::{GridConfig, GridError};
pub use guided::{GuidedConfig, GuidedPaths, PairwiseRule};
pub use guided_passage::{PassageEstimates, PassageQuestion};
pub use linearisation::{GaussianLaw, Linearisation, LinearisationError, Quadrature};
pub use normal_tail::upper_tail;
pub use sde_integrators::{Estimate, SubsetConfig, Uncertainty};
pub use subset_passage::subset_passage;
pub use tail::{TailError, TailPaths, Tails};
pub use weights::GuidedEstimate;
