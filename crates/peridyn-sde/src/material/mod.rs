//! The material of a body: constants of bonds from moduli and toughness, the horizon, strengths and stiffnesses that vary in space.
//!
//! Nothing here knows bonds in a list, forces or time: a constant follows from lengths, moduli and random numbers. Fields of values and
//! independent strengths are drawn at nodes and elements that the caller names.

pub(crate) mod disorder;
pub(crate) mod elasticity;
pub(crate) mod horizon;
pub(crate) mod strain;
pub(crate) mod weakest_link;
