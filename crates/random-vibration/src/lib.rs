#![doc = include_str!("../README.md")]

mod density;
mod guided_paths;
mod guides;
mod linearisation;
mod subset_passage;
mod tail;

pub use density::grid::GridDensity;
pub use density::grid_config::{GridConfig, GridError};
pub use guided_paths::free_passage::{FreePassages, free_passages};
pub use guided_paths::guided::GuidedPaths;
pub use guided_paths::guided_config::{GuidedConfig, PairwiseRule};
pub use guided_paths::guided_exceedance::ExceedanceQuestion;
pub use guided_paths::guided_passage::PassageQuestion;
pub use guided_paths::guided_study::{GuidedEstimates, GuidedStudy};
pub use guided_paths::path_runner::PathBlock;
pub use guided_paths::weights::GuidedEstimate;
pub use linearisation::{GaussianLaw, Linearisation, LinearisationError, Quadrature};
pub use sde_integrators::{Estimate, SubsetConfig, Uncertainty};
pub use subset_passage::subset_passage;
pub use tail::{TailError, TailPaths, Tails};
