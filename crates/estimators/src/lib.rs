#![doc = include_str!("../README.md")]

mod blocks;
mod comoments;
mod control;
mod cube;
mod error;
mod joe_kuo;
mod ladder;
mod multifidelity;
mod multilevel;
mod multilevel_result;
mod parallel;
mod path_ladder;
mod points;
mod rates;
mod sensitivity;
mod statistic;
mod survey;

pub use blocks::{Block, BlockId, Progress};
pub use comoments::Comoments;
pub use control::{ControlledSamples, SampledMoments, Surrogate};
pub use cube::UnitCube;
pub use error::Error;
pub use ladder::{Failure, Ladder, Levels, Pair};
pub use multifidelity::{ModelReport, Multifidelity, MultifidelityResult};
pub use multilevel::Multilevel;
pub use multilevel_result::{LevelReport, MultilevelResult, TargetResult};
pub use path_ladder::PathLadder;
pub use points::{Sampling, SobolPoints};
pub use rates::Bias;
pub use sde_integrators::{Estimate, Uncertainty};
pub use sensitivity::SobolIndices;
pub use statistic::{Statistic, Target};
