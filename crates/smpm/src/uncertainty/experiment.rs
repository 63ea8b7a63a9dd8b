//! A run as a function of random parameters.

use crate::error::Error;
use crate::number::Number;
use crate::simulation::Simulation;

/// A run as a function of `N` random parameters, written once over every number type.
///
/// What it refuses, by the errors of the materials it builds, is outside the range of a parameter.
pub trait Experiment<const D: usize, const N: usize>: Sync {
    /// The simulation at its start, with the parameters `x` in the order of the random vector. Grid, places of particles and
    /// steps must not depend on them.
    ///
    /// # Errors
    /// Where the parameters are out of range.
    fn simulation<S: Number>(&self, x: &[S; N]) -> Result<Simulation<S, D>, Error>;
}
