#![doc = include_str!("../README.md")]

mod diagnostics;
mod emulator;
mod error;
mod factor;
mod gaussian;
mod lack_of_fit;
mod mixture;
mod parameter;
mod parameter_space;
mod polynomial;
mod posterior;
mod regressions;
mod sampler_config;
mod summaries;
mod target;
mod tempered;

pub use diagnostics::{bulk_effective_sample_size, effective_sample_size, r_hat};
pub use emulator::Emulator;
pub use error::Error;
pub use gaussian::Observations;
pub use lack_of_fit::{Component, ComponentFit};
pub use mixture::EmulatorMixture;
pub use parameter::{Parameter, Prior, Scale};
pub use parameter_space::ParameterSpace;
pub use posterior::{
    LEAST_CONTRACTION, POSTERIOR_QUANTILES, ParameterPosterior, Posterior, Verdict,
};
pub use sampler_config::SamplerConfig;
pub use summaries::{Absent, Summaries};
