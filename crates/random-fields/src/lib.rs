#![doc = include_str!("../README.md")]

mod box_modes;
mod conditioned;
mod correlation;
mod error;
mod exponential_modes;
mod gaussian_field;
mod lattice_field;
mod marginal;
mod matern;
mod pivot_modes;
mod pivoted_cholesky;
mod random_field;
mod spatial_correlation;
mod symmetric_eigen;
mod truncation;

pub use conditioned::{ConditionedField, Measurement};
pub use correlation::{Correlation, CorrelationFunction};
pub use error::Error;
pub use gaussian_field::{GaussianField, field_stream};
pub use marginal::Marginal;
pub use pivoted_cholesky::{Enough, LowRank, pivoted_cholesky};
pub use random_field::RandomField;
pub use spatial_correlation::{Axes, SpatialCorrelation};
pub use truncation::Truncation;
