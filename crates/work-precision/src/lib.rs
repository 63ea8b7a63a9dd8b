#![doc = include_str!("../README.md")]

pub mod charts;
pub mod cli;
pub mod draw;
pub mod overview;
pub mod problems;
pub mod stability;
