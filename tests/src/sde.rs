//! What only cases of `sde-integrators` use.

pub mod explosion;
pub mod order_claims;
