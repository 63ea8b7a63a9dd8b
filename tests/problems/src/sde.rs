//! What cases and charts of `sde-integrators` share: problems, the table of methods, and the order harness.
//!
//! A method that has a line in [`methods`] is measured on every problem of its class: strong and weak order, order
//! without noise, and its place on the charts.

pub mod damper;
pub mod linear;
pub mod methods;
pub mod orders;
pub mod problems;
pub mod quadrature;
pub mod reference;
pub mod stability;
