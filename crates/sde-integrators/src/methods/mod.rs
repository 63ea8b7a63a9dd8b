//! Methods that advance one path, or a group of paths in lanes, by one step.
//!
//! Nothing here draws a number itself, or knows how many paths an ensemble has.

pub(crate) mod euler_maruyama;
pub(crate) mod heun;
pub(crate) mod lane_paths;
pub(crate) mod lane_sde;
pub(crate) mod linear_solve;
pub(crate) mod milstein;
pub(crate) mod semi_implicit_euler;
pub(crate) mod shark;
pub(crate) mod sra3;
pub(crate) mod sriw1;
pub(crate) mod strang_oscillator;
pub(crate) mod theta;
