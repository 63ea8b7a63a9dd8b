#![doc = include_str!("../README.md")]

mod along;
mod error;
mod expansion;
mod forward;
mod moments;
mod monte_carlo;
mod numbers;
mod random_vector;
mod response;
mod sigma_points;
mod symmetric;
mod trust;

pub use along::{AlongDirections, Slopes};
pub use error::Error;
pub use expansion::Expansion;
pub use forward::{ForwardDifferentiation, HighestOrder};
pub use moments::Moments;
pub use monte_carlo::{Judgement, MonteCarlo};
pub use numbers::gradient::Gradient;
pub use numbers::jet::{Jet, LANES};
pub use numbers::real::{InLanes, Real};
pub use numbers::scalar::Scalar;
pub use random_vector::{Marginal, RandomVector};
pub use response::Response;
pub use sde_integrators::{Estimate, Uncertainty};
pub use sigma_points::{SIGMA_POINT_DISTANCE, SigmaPoints};
pub use simd_lanes::Mask;
pub use trust::{Trust, Verdict};
