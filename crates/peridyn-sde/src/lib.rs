#![doc = include_str!("../README.md")]

mod bonds;
mod correlation;
mod disorder;
mod elasticity;
mod error;
mod gaussian_field;
mod horizon;
mod lattice_field;
pub mod law;
mod marginal;
mod mobility;
mod network;
mod nodes;
mod pivoted_cholesky;

pub use bonds::{Bond, BondConfig, Bonds, VolumeCorrection};
pub use correlation::{Correlation, CorrelationFunction};
pub use disorder::{BondValue, DisorderField, between_nodes, from_column};
pub use elasticity::{Condition, Influence, critical_stretch, micromodulus};
pub use error::Error;
pub use gaussian_field::GaussianField;
pub use horizon::Horizon;
pub use law::BondLaw;
pub use marginal::Marginal;
pub use mobility::{CompactMobility, CorrelatedMobility, DisplacementNoise, Mobility};
pub use network::Network;
pub use nodes::Nodes;
