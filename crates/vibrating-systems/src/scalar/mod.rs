//! Systems with closed forms: scalar ones, and the Ornstein-Uhlenbeck process in any dimension.
//!
//! Nothing here knows a structure.

pub(crate) mod bistable;
pub(crate) mod cox_ingersoll_ross;
pub(crate) mod geometric_brownian_motion;
pub(crate) mod ornstein_uhlenbeck;
