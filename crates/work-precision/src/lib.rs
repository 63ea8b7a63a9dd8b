#![doc = include_str!("../README.md")]

mod charts;
pub mod cli;
mod draw;
mod overview;
mod problems;
mod stability;
