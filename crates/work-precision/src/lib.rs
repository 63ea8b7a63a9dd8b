#![doc = include_str!("../README.md")]

pub mod charts;
pub mod cli;
pub mod context;
pub mod draw;
pub mod order;
pub mod overview;
pub mod problems;
pub mod processes;
pub mod quantile;
pub mod record;
pub mod stability;
