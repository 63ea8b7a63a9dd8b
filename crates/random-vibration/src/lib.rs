#![doc = include_str!("../README.md")]

mod adjoints;
mod backward;
mod discrete_gaussian;
mod event;
mod free_passage;
mod grid;
mod grid_config;
mod guided;
mod guided_config;
mod guided_exceedance;
mod guided_passage;
mod guided_study;
mod linearisation;
mod pairwise_regression;
mod path_runner;
mod pilots;
mod regression;
mod remap;
mod small_regression;
mod subset_passage;
mod tail;
mod weights;

pub use free_passage::{FreePassages, free_passages};
pub use grid::GridDensity;
pub use grid_config::{GridConfig, GridError};
pub use guided::GuidedPaths;
pub use guided_config::{GuidedConfig, PairwiseRule};
pub use guided_exceedance::ExceedanceQuestion;
pub use guided_passage::PassageQuestion;
pub use guided_study::{GuidedEstimates, GuidedStudy};
pub use linearisation::{GaussianLaw, Linearisation, LinearisationError, Quadrature};
pub use path_runner::PathBlock;
pub use sde_integrators::{Estimate, SubsetConfig, Uncertainty};
pub use subset_passage::subset_passage;
pub use tail::{TailError, TailPaths, Tails};
pub use weights::GuidedEstimate;
