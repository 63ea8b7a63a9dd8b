//! Explicit schemes for `dX/dt = v(t, X)`, the state that a step changes, and the smoothing lengths over a step.
//!
//! A scheme is given a velocity as a function. Nothing here knows what it follows from, how long a step may be, or when the
//! cloud is remapped.

mod begin;
mod classical;
mod lawson;
pub(crate) mod smoothing;
pub(crate) mod state;
mod sums;

pub(crate) use begin::Begin;

use crate::error::Error;
use crate::scheme::Scheme;

/// The stages of a step.
#[derive(Debug)]
pub(crate) struct Stages<const D: usize> {
    /// Positions of a stage; after the last one those at the end of the step.
    pub(crate) x: Vec<[f64; D]>,
    /// Velocities of the stages, of which the first is `v(t, x_0)` before a step; in Lawson's form what remains of them.
    pub(crate) k: [Vec<[f64; D]>; 4],
}

impl<const D: usize> Stages<D> {
    pub(crate) fn new(n: usize) -> Self {
        Self { x: vec![[0.0; D]; n], k: std::array::from_fn(|_| vec![[0.0; D]; n]) }
    }

    /// As [`Self::advance`] by the classical method of order 4, without compiling the others for its velocity.
    pub(crate) fn runge_kutta_4(
        &mut self,
        begin: &Begin<'_, D>,
        velocity: impl FnMut(f64, &[[f64; D]], &mut [[f64; D]]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        classical::runge_kutta_4(&mut self.x, &mut self.k, begin, velocity)
    }

    /// `x(t + dt)` from `x_0 = x(t)` and `k_1 = v(t, x_0)`, by the scheme.
    pub(crate) fn advance(
        &mut self,
        scheme: Scheme,
        begin: &Begin<'_, D>,
        velocity: impl FnMut(f64, &[[f64; D]], &mut [[f64; D]]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let Self { x, k } = self;
        match scheme {
            Scheme::ForwardEuler => {
                classical::forward_euler(x, k, begin);
                Ok(())
            }
            Scheme::RungeKutta4 => classical::runge_kutta_4(x, k, begin, velocity),
            Scheme::LawsonAdamsBashforth2 => lawson::adams_bashforth_2(x, k, begin, velocity),
        }
    }
}
