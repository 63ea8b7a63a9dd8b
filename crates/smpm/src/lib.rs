#![doc = include_str!("../README.md")]

mod error;
pub mod material;
pub mod tensor;

pub use error::{Error, Fault};
