#![doc = include_str!("../README.md")]

mod body;
mod bonds;
mod crossing;
mod elasticity;
mod error;
mod fast;
mod horizon;
pub mod law;
mod network;
mod nodes;
mod real;

pub use body::{AtStrength, Body, BrokenBond, Cause};
pub use bonds::{Bond, BondConfig, Bonds, VolumeCorrection};
pub use crossing::Crossing;
pub use elasticity::{Condition, Influence, critical_stretch, micromodulus};
pub use error::Error;
pub use fast::{BondList, LatticeBody, Strain};
pub use horizon::Horizon;
pub use law::BondLaw;
pub use network::Network;
pub use nodes::Nodes;
pub use real::Real;
