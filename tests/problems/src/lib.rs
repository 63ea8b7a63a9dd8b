//! Problems that charts and the proof share, with their references, and what both need to run them.
//!
//! The modules [`fpk`], [`peridyn`], [`sde`] and [`smpm`] hold a problem each with its parameters, its reference and its methods.
//! Nothing here knows a claim or a chart: `verification` and `work-precision` both build on this package and not on each other.

#![allow(
    clippy::missing_errors_doc,
    reason = "a chart or a case ends with the error of its scene, its file or its solver, whichever that is"
)]

pub mod context;
pub mod fpk;
pub mod order;
pub mod peridyn;
pub mod processes;
pub mod quantile;
pub mod record;
pub mod sde;
pub mod smpm;
