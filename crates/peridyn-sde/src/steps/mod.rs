//! One step of each scheme. A scheme owns the buffers that it needs beside the state.

mod baoab;
mod conjugate_gradients;
mod euler;
mod heun;
mod theta;

use crate::bodies::body::Body;
use crate::dynamics::motion::Motion;
use crate::dynamics::scheme::{Dynamics, Scheme};
use crate::error::Error;
use crate::real::Real;
use baoab::Baoab;
use euler::Euler;
use heun::Heun;
use theta::Theta;

/// The scheme of a simulation with its buffers.
#[derive(Debug)]
pub(crate) enum Stepper<T> {
    Euler(Euler<T>),
    Heun(Heun<T>),
    Theta(Theta<T>),
    Baoab(Baoab<T>),
}

impl<T: Real> Stepper<T> {
    /// That of some dynamics of so many unknowns, of all lanes together.
    pub(crate) fn new(dynamics: &Dynamics, n_unknowns: usize) -> Self {
        match *dynamics {
            Dynamics::Overdamped { scheme: Scheme::Heun, .. } => Self::Heun(Heun::new(n_unknowns)),
            Dynamics::Overdamped { scheme: Scheme::Theta(theta), .. } => {
                Self::Theta(Theta::new(theta))
            }
            Dynamics::Overdamped { scheme, temperature, .. } => {
                let averages = scheme == Scheme::LeimkuhlerMatthews && temperature > 0.0;
                Self::Euler(Euler::new(averages, n_unknowns))
            }
            Dynamics::Inertial { friction, temperature, .. } => {
                Self::Baoab(Baoab::new(friction, temperature, n_unknowns))
            }
        }
    }

    /// Displacements and velocities of one step; bonds that the forces of the step find at their strength break.
    pub(crate) fn step<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        body: &mut dyn Body<T, D, L>,
    ) -> Result<(), Error> {
        match self {
            Self::Euler(euler) => euler.step(motion, body),
            Self::Heun(heun) => heun.step(motion, body),
            Self::Theta(theta) => theta.step(motion, body),
            Self::Baoab(baoab) => baoab.step(motion, body),
        }
    }
}
