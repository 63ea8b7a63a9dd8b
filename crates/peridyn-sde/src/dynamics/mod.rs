//! A body in time: loads, mobility or masses, noise, the check of the step, and the state between two steps.
//!
//! One step of each scheme is in `steps`, which reads and moves what is kept here. A body is known by its trait alone.

pub(crate) mod config;
pub(crate) mod kicks;
pub(crate) mod loading;
pub(crate) mod motion;
pub(crate) mod report;
pub(crate) mod resistance;
pub(crate) mod saved;
pub(crate) mod scheme;
pub(crate) mod simulation;
pub(crate) mod stiffest;
pub(crate) mod swing;
