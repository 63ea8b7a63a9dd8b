#![doc = include_str!("../README.md")]

mod bonds;
mod cut;
mod elasticity;
mod error;
mod horizon;
pub mod law;
mod network;
mod nodes;
mod path;
pub mod statistics;
mod surface;

pub use bonds::{Bond, BondConfig, Bonds, VolumeCorrection};
pub use elasticity::{Condition, Influence, critical_stretch, micromodulus};
pub use error::Error;
pub use horizon::Horizon;
pub use law::BondLaw;
pub use network::Network;
pub use nodes::Nodes;
pub use path::{
    Branch, CrackPath, Fractured, FrontPoint, Notch, PathConfig, PlaneNotch, crack_front,
    crack_path,
};
pub use surface::SurfaceCorrection;
