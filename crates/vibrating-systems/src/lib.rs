#![doc = include_str!("../README.md")]

mod error;
mod excitation;
mod linear_law;
pub mod matrix;
mod oscillators;
mod scalar;
mod stationary;

pub use error::Error;
pub use excitation::filter::{CloughPenzienParameters, Filter, KanaiTajimiParameters};
pub use excitation::filtered::Filtered;
pub use excitation::window::{TabulatedWindow, Window};
pub use oscillators::bouc_wen::{BoucWen, BoucWenParameters, StrangBoucWen};
pub use oscillators::duffing::{Duffing, DuffingParameters};
pub use oscillators::hysteresis::Hysteresis;
pub use oscillators::linear_oscillator::{LinearOscillator, LinearOscillatorParameters};
pub use oscillators::shear_building::{Ground, ShearBuilding, ShearBuildingParameters, Storey};
pub use oscillators::two_storey::{TwoStorey, TwoStoreyParameters};
pub use oscillators::van_der_pol::{VanDerPolRayleigh, VanDerPolRayleighParameters};
pub use oscillators::viscous_damper::{ViscousDamper, ViscousDamperParameters};
pub use scalar::bistable::{Bistable, BistableParameters};
pub use scalar::cox_ingersoll_ross::{CoxIngersollRoss, CoxIngersollRossParameters};
pub use scalar::geometric_brownian_motion::GeometricBrownianMotion;
pub use scalar::ornstein_uhlenbeck::{OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters};
pub use stationary::StationaryOscillator;
