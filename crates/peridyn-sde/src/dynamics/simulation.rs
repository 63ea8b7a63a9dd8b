//! A body in time: `L` realisations of it, step by step.

use std::fmt;

use crate::bodies::body::Body;
use crate::dynamics::config::SimulationConfig;
use crate::dynamics::loading::Loading;
use crate::dynamics::motion::{Column, Motion, of_lane};
use crate::dynamics::report::StepReport;
use crate::dynamics::scheme::Dynamics;
use crate::error::Error;
use crate::real::Real;
use crate::steps::Stepper;

/// A body in time, `L` realisations side by side.
pub struct Simulation<T: Real, const D: usize, const L: usize> {
    pub(crate) body: Box<dyn Body<T, D, L>>,
    pub(crate) motion: Motion<T, D, L>,
    pub(crate) stepper: Stepper<T>,
    /// The largest `z`, or the square of `omega h`.
    relative_step: f64,
}

impl<T: Real, const D: usize, const L: usize> fmt::Debug for Simulation<T, D, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Simulation").field("motion", &self.motion).finish_non_exhaustive()
    }
}

impl<T: Real, const D: usize, const L: usize> Simulation<T, D, L> {
    /// A body at rest at time 0, whose realisations have these numbers.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the step, or for a negative temperature, friction or confinement;
    /// [`Error::Length`] for a loading or a mobility of another body; [`Error::Unstable`] for a step beyond the stable range of
    /// the scheme; [`Error::NoPathBetween`] for a bridge where there can be none.
    pub fn new(
        body: impl Body<T, D, L> + 'static,
        loading: Loading<D>,
        config: SimulationConfig,
        realisations: [u64; L],
    ) -> Result<Self, Error> {
        Self::of_any(Box::new(body), loading, config, realisations)
    }

    /// As [`Simulation::new`], of a body whose kind is known at run time.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn of_any(
        mut body: Box<dyn Body<T, D, L>>,
        loading: Loading<D>,
        config: SimulationConfig,
        realisations: [u64; L],
    ) -> Result<Self, Error> {
        config.check()?;
        let mut motion = Motion::new(&mut *body, loading, config, realisations)?;
        let relative_step = motion.stable_step(&mut *body)?;
        motion.impose_displacements();
        motion.evaluate_intact(&mut *body)?;
        let stepper = Stepper::new(&motion.config.dynamics, motion.u.len());
        Ok(Self { body, motion, stepper, relative_step })
    }

    /// `z = h M lambda` of the stiffest mode at rest; in inertial dynamics `(h omega)^2`.
    #[must_use]
    pub fn relative_step(&self) -> f64 {
        self.relative_step
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &dyn Body<T, D, L> {
        &*self.body
    }

    /// The time.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.motion.time
    }

    /// Steps taken.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.motion.step
    }

    /// Displacements of a lane (length).
    #[must_use]
    pub fn displacements(&self, lane: usize) -> Vec<[f64; D]> {
        of_lane::<T, D, L>(&self.motion.u, lane)
    }

    /// Velocities of a lane (length over time); zero in overdamped dynamics.
    #[must_use]
    pub fn velocities(&self, lane: usize) -> Vec<[f64; D]> {
        of_lane::<T, D, L>(&self.motion.v, lane)
    }

    /// Forces of the bonds on the nodes of a lane, of the last evaluation (force): at the start of the last step, in inertial
    /// dynamics at its end.
    #[must_use]
    pub fn forces(&self, lane: usize) -> Vec<[f64; D]> {
        of_lane::<T, D, L>(&self.motion.bond_forces, lane)
    }

    /// The force of the bonds on some nodes in a lane (force): the reaction of a prescribed displacement is its opposite.
    #[must_use]
    pub fn pull_on(&self, nodes: &[usize], lane: usize) -> [f64; D] {
        let mut sum = [0.0; D];
        for &node in nodes {
            for k in 0..D {
                sum[k] += self.motion.bond_forces[(node * D + k) * L + lane].to_f64();
            }
        }
        sum
    }

    /// The energy of the bonds of a lane (energy).
    #[must_use]
    pub fn energy(&self, lane: usize) -> f64 {
        self.body.energy(&self.motion.u, lane)
    }

    /// The damage of each node in a lane: the part of its bonds that is lost, each weighed by its stiffness.
    #[must_use]
    pub fn damage(&self, lane: usize) -> Vec<f64> {
        self.body.bonds().damage_of_nodes(|bond| self.body.bond_damage(bond, lane))
    }

    /// Sets the displacements of a lane (length), except prescribed ones.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Node`] for one that is not finite.
    pub fn set_displacements(&mut self, lane: usize, u: &[[f64; D]]) -> Result<(), Error> {
        self.motion.set_lane(Column::Displacements, lane, u)?;
        self.motion.evaluate_intact(&mut *self.body)
    }

    /// Sets the velocities of a lane (length over time), in inertial dynamics, except those of prescribed displacements.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Node`] for one that is not finite.
    pub fn set_velocities(&mut self, lane: usize, v: &[[f64; D]]) -> Result<(), Error> {
        self.motion.set_lane(Column::Velocities, lane, v)
    }

    /// Cuts bonds in all lanes, as a notch does.
    ///
    /// # Errors
    /// [`Error::Length`] for a number that no bond has.
    pub fn cut(&mut self, bonds: &[usize]) -> Result<(), Error> {
        self.motion.cut(&mut *self.body, bonds)
    }

    /// Whether the forces are those at the end of the last step, not at its start.
    pub(crate) fn has_forces_of_end(&self) -> bool {
        matches!(self.motion.config.dynamics, Dynamics::Inertial { .. })
    }

    /// Forces at the present displacements, at which no bond breaks.
    pub(crate) fn evaluate_intact(&mut self) -> Result<(), Error> {
        self.motion.evaluate_intact(&mut *self.body)
    }

    /// One step of the length `dt`. After an error the state is not to be used.
    ///
    /// # Errors
    /// [`Error::Lost`] where a displacement is no longer finite, with step, time, node and realisation; those of the body.
    pub fn step(&mut self) -> Result<StepReport, Error> {
        let Self { body, motion, stepper, .. } = self;
        motion.begin_step(&**body);
        stepper.step(motion, &mut **body)?;
        motion.end_step(&mut **body)
    }
}
