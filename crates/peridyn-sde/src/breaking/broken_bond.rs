//! A bond that broke, and why.

/// Why a bond broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// A notch cut it.
    Cut,
    /// Its stretch was at its strength at the end of a step.
    Stretch,
    /// It was below its strength at both ends of a step, and crossed it in between.
    Crossing,
    /// Its law wore it down.
    Wear,
}

/// A bond that broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BrokenBond {
    /// Its number in [`Bonds::all`](crate::Bonds::all).
    pub bond: usize,
    /// In which lanes, a bit for each.
    pub lanes: u16,
    /// Why.
    pub cause: Cause,
}
