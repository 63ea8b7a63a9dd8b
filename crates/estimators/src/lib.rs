#![doc = include_str!("../README.md")]

mod blocks;
mod comoments;
mod control;
mod error;
mod ladder;
mod multilevel;
mod multilevel_result;
mod parallel;
mod path_ladder;
mod rates;
mod statistic;
mod survey;

pub use blocks::{Block, BlockId, Progress};
pub use comoments::Comoments;
pub use control::{ControlledSamples, SampledMoments, Surrogate};
pub use error::Error;
pub use ladder::{Failure, Ladder, Levels, Pair};
pub use multilevel::Multilevel;
pub use multilevel_result::{LevelReport, MultilevelResult, TargetResult};
pub use path_ladder::PathLadder;
pub use rates::Bias;
pub use sde_integrators::{Estimate, Uncertainty};
pub use statistic::{Statistic, Target};
