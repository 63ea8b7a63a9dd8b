//! The configuration of a simulation.

use sde_integrators::Noise;

use crate::dynamics::scheme::Dynamics;
use crate::error::{Error, not_negative, positive};

/// When bond failure is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Breaking {
    /// At the ends of steps: what a path did in between is not seen, an error of the order `sqrt(h)` in the rate of breaking.
    AtEnds,
    /// In between as well, by the test of a bridge: see [`Crossing`](crate::Crossing). Not with Leimkuhler and Matthews' method,
    /// whose steps are not those of the path, and not for inertial dynamics, whose paths are smooth.
    Bridge,
}

/// What is needed to step a body.
#[derive(Debug, Clone)]
pub struct SimulationConfig {
    /// What moves the nodes.
    pub dynamics: Dynamics,
    /// The step `h` (time).
    pub dt: f64,
    /// When bond failure is checked.
    pub breaking: Breaking,
    /// `epsilon` of the confining energy `epsilon u^2/2` of each free component (force over length), zero for none: it holds
    /// nodes that have lost all bonds, and multiplies the variance of a mode by `lambda/(lambda + epsilon)`.
    pub confinement: f64,
    /// The noise of all.
    pub noise: Noise,
}

impl SimulationConfig {
    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("step", self.dt)?;
        not_negative("confinement", self.confinement)?;
        self.dynamics.check()
    }
}
