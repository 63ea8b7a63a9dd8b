#![doc = include_str!("../README.md")]

mod conditioned;
mod correlations;
mod error;
mod gaussian_field;
mod lattice_field;
mod marginal;
mod modes;
mod pivoted_cholesky;
mod random_field;
mod symmetric_eigen;

pub use conditioned::{ConditionedField, Measurement};
pub use correlations::correlation::{Correlation, CorrelationFunction};
pub use correlations::spatial_correlation::{Axes, SpatialCorrelation};
pub use error::Error;
pub use gaussian_field::{GaussianField, field_stream};
pub use marginal::Marginal;
pub use modes::truncation::Truncation;
pub use pivoted_cholesky::{Enough, LowRank, pivoted_cholesky};
pub use random_field::RandomField;
