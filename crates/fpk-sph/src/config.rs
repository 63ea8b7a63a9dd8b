//! Parameters of a simulation.

use crate::method::Method;
use crate::start::InitialLattice;

/// Parameters of a simulation besides the system and its initial distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config<const D: usize> {
    /// The combination of choices that carries the density.
    pub method: Method,
    /// The lattice on which the particles start.
    pub lattice: InitialLattice<D>,
    /// A time that is characteristic of the system: the natural period of an oscillator; for a process without one, the
    /// time in which the noise doubles the variance of the start. The step has collapsed below 1e-6 of it, and what the
    /// flow-map fit does not see is taken out within 0.3 of it.
    pub reference_period: f64,
    /// Most steps that a run may take.
    pub most_steps: u64,
}

/// Steps that a run may take where the caller sees no reason for another number: honest runs of the paper's method to
/// `t = 10` take about 5,000, the paper reports 11,000.
pub const DEFAULT_MOST_STEPS: u64 = 200_000;

/// The step has collapsed below this part of the reference period. Honest runs have been seen at 2e-5, collapsed ones
/// below 1e-7.
pub const COLLAPSED_STEP: f64 = 1e-6;
