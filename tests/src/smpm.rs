//! What only cases of `smpm` use.

pub mod riemann;
