//! The report of a step.

use crate::breaking::broken_bond::BrokenBond;

/// What happened in a step.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct StepReport {
    /// Which step it was, from 1 on.
    pub step: u64,
    /// The time at its end.
    pub time: f64,
    /// Bonds that broke: those found at their strength by the forces of this step, and those that crossed it in it.
    pub broken: Vec<BrokenBond>,
}
