#![doc = include_str!("../README.md")]

mod blocks;
mod cholesky;
mod ensemble;
mod error;
mod estimate;
mod euler_maruyama;
mod integrator;
mod law;
mod noise;
mod normal;
mod semi_implicit_euler;
mod state_space;
mod strang_oscillator;
mod system;

pub use blocks::{BLOCK_LENGTH, reduce_blocks};
pub use ensemble::{Ensemble, EnsembleConfig, Observable, simulate};
pub use error::{Error, StepError};
pub use estimate::{Accumulator, Estimate, Uncertainty};
pub use euler_maruyama::EulerMaruyama;
pub use integrator::Integrator;
pub use law::{GaussianComponent, GaussianMixture, InitialLaw};
pub use noise::{Increment, Noise, PathNoise, Purpose, Stream, WORDS_PER_PAIR};
pub use semi_implicit_euler::SemiImplicitEuler;
pub use state_space::StateSpace;
pub use strang_oscillator::{LinearFlows, StrangOscillator};
pub use system::{Additive, General, NoiseClass, Sde, SecondOrder, check_diffusion_divergence};
