#![doc = include_str!("../README.md")]

mod comoments;
mod designs;
mod error;
mod ladder;
mod levels;
mod parallel;
mod quantal_response;
mod rates;
mod surrogates;
mod tails;

pub use comoments::Comoments;
pub use designs::cube::UnitCube;
pub use designs::designed::DesignedRuns;
pub use designs::points::{Sampling, SobolPoints};
pub use designs::quantile::{QuantileInterval, quantile};
pub use designs::sensitivity::SobolIndices;
pub use error::Error;
pub use ladder::{Failure, Ladder, Levels, Pair};
pub use levels::blocks::{Block, BlockId, Progress};
pub use levels::multilevel::Multilevel;
pub use levels::multilevel_result::{LevelReport, MultilevelResult, TargetResult};
pub use levels::path_ladder::PathLadder;
pub use levels::statistic::{Statistic, Target, Tolerance};
pub use quantal_response::{ProbabilityBand, QuantalResponse, Trial};
pub use rates::Bias;
pub use sde_integrators::{Estimate, SubsetConfig, Uncertainty};
pub use surrogates::control::{ControlledSamples, SampledMoments, Surrogate};
pub use surrogates::polynomial::{PolynomialControl, PolynomialMoments};
pub use tails::normal_model::{ModelRuns, NormalModel};
pub use tails::tail_design_point::TailPoint;
pub use tails::tail_sampling::{TailEstimate, TailSampling};
