#![doc = include_str!("../README.md")]

mod system;

pub use system::{Additive, General, NoiseClass, Sde, SecondOrder, check_diffusion_divergence};
