//! A run as a function of random inputs.

use crate::error::Error;
use crate::points::compiled_points::Number;
use crate::simulation::Simulation;

/// A run as a function of random inputs, written once over every number type: parameters of materials, or coefficients of random
/// fields, of which bodies are made by [`Body::varying`](crate::Body::varying).
///
/// What it refuses, by the errors of the materials it builds, is outside the range of an input.
pub trait Experiment<const D: usize>: Sync {
    /// The simulation at its start, with the inputs `x` in the order of the study. Grid, number of particles and steps must not
    /// depend on them; where jets carry derivatives, nor must the places and velocities of particles.
    ///
    /// # Errors
    /// Where the inputs are out of range, or others than the experiment takes.
    fn simulation<S: Number>(&self, x: &[S]) -> Result<Simulation<S, D>, Error>;
}

/// The inputs of an experiment that takes `N` of them.
///
/// # Errors
/// [`Error::OtherInputs`] for another number of them.
pub fn exactly<S: Copy, const N: usize>(x: &[S]) -> Result<[S; N], Error> {
    x.try_into().map_err(|_| Error::OtherInputs { value: x.len(), expected: N })
}
