//! Bodies of bonds with known answers.

pub mod background;
pub mod first_passage;
pub mod network;
pub mod nonlinear;
pub mod notched_plate;
pub mod one_bond;
pub mod sample;
pub mod slow_plate;
pub mod stationary;
