#![doc = include_str!("../README.md")]

mod arrays;
mod elementary;
mod level;
mod numbers;
mod one_lane;
mod portable;
mod registers;
mod sealed;
#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
mod x86_fours;

pub use arrays::{from_fn, map};
pub use elementary::{exp, ln, minus_twice_ln, power, sin_cos};
pub use level::{Float, SimdLevel, dispatch, dispatch_narrow};
pub use numbers::{Lanes, Mask};
pub use registers::{MOST_LANES, Registers, Work};
