//! What only cases of `smpm` use.

pub(crate) mod riemann;
