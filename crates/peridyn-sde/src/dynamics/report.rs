//! The report of a step.

use crate::breaking::broken_bond::Cause;

/// What happened in a step.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct StepReport {
    /// Which step it was, from 1 on.
    pub step: u64,
    /// The time at its end.
    pub time: f64,
    /// Bonds that broke: those found at their strength by the forces of this step, and those that crossed it in it.
    pub broken: Vec<BrokenAt>,
}

/// A bond that broke, when and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrokenAt {
    /// Its number in [`Bonds::all`](crate::Bonds::all).
    pub bond: usize,
    /// In which lanes, a bit for each.
    pub lanes: u16,
    /// Why.
    pub cause: Cause,
    /// In which step.
    pub step: u64,
    /// At the end of which time.
    pub time: f64,
}
