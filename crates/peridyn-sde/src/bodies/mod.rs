//! Bodies: nodes with volumes, their bonds, cuts through them, and what a time step or an equilibrium asks of them.
//!
//! [`Body`](body::Body) is the interface: it computes forces and keeps which bonds are intact. Whether and when a bond breaks is decided
//! elsewhere; a body knows no time, no scheme and no noise. [`Network`](network::Network) is the body of any bond law, one bond after
//! the other; those in wide registers are in `fast`.

pub(crate) mod body;
pub(crate) mod bond_config;
pub(crate) mod bonds;
pub(crate) mod cut;
pub(crate) mod linear_pull;
pub(crate) mod network;
pub(crate) mod nodes;
pub(crate) mod note;
pub(crate) mod surface;
