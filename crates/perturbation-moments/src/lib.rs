#![doc = include_str!("../README.md")]

mod along;
mod error;
mod expansion;
mod forward;
mod gradient;
mod jet;
mod moments;
mod monte_carlo;
mod random_vector;
mod real;
mod response;
mod scalar;
mod sigma_points;
mod symmetric;
mod trust;

pub use along::{AlongDirections, Slopes};
pub use error::Error;
pub use expansion::Expansion;
pub use forward::{ForwardDifferentiation, HighestOrder};
pub use gradient::Gradient;
pub use jet::{Jet, LANES};
pub use moments::Moments;
pub use monte_carlo::{Judgement, MonteCarlo};
pub use random_vector::{Marginal, RandomVector};
pub use real::{InLanes, Real};
pub use response::Response;
pub use scalar::Scalar;
pub use sde_integrators::{Estimate, Uncertainty};
pub use sigma_points::{SIGMA_POINT_DISTANCE, SigmaPoints};
pub use simd_lanes::Mask;
pub use trust::{Trust, Verdict};
