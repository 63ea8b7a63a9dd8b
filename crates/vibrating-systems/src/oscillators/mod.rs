//! Structures: oscillators of one degree of freedom, buildings of several storeys, and their hysteresis.
//!
//! Nothing here knows a filter.

pub(crate) mod bouc_wen;
pub(crate) mod duffing;
pub(crate) mod first_order;
pub(crate) mod hysteresis;
pub(crate) mod linear_oscillator;
pub(crate) mod shear_building;
pub(crate) mod shear_chain;
pub(crate) mod two_storey;
pub(crate) mod van_der_pol;
pub(crate) mod viscous_damper;
