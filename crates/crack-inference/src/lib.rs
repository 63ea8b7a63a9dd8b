#![doc = include_str!("../README.md")]

mod error;
mod factor;
mod likelihood;
mod parameter;
mod parameter_space;
mod sampling;
mod summaries;

pub use error::Error;
pub use likelihood::emulator::Emulator;
pub use likelihood::gaussian::Observations;
pub use likelihood::lack_of_fit::{Component, ComponentFit};
pub use likelihood::mixture::EmulatorMixture;
pub use parameter::{Parameter, Prior, Scale};
pub use parameter_space::ParameterSpace;
pub use sampling::diagnostics::{bulk_effective_sample_size, effective_sample_size, r_hat};
pub use sampling::posterior::{
    FROM_BOUND, LEAST_CONTRACTION, POSTERIOR_QUANTILES, ParameterPosterior, Posterior, Verdict,
};
pub use sampling::sampler_config::SamplerConfig;
pub use summaries::{Absent, Summaries};
