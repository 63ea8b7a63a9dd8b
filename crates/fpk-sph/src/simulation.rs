//! A simulation as a value: checked once, stepped, observed, saved and restored.

use std::io::{Read, Write};

use sde_integrators::{GaussianMixture, Sde};

use crate::compiled::passes;
use crate::density::cell_integral::CellIntegral;
use crate::density::density_field::DensityField;
use crate::error::{Error, finite};
use crate::method::config::Config;
use crate::method::remapping::{Remapped, Remapping};
use crate::parallel::in_pool;
use crate::scheme::Scheme;
use crate::score::ScoreEstimator;
use crate::solver::Solver;
use crate::solver::moment_balance::{Correction, MeanAndCovariance};
use crate::solver::report::{StepReport, Work};
use crate::system::coefficients::OfSystem;
use vibrating_systems::matrix::Matrix;

/// The density of a system on moving particles (Canor & Denoël 2013, eq 11-14):
///
/// $$ \frac{dX}{dt} = v = f - \nabla\cdot D - D \nabla\log\psi, $$
///
/// with masses that never change. `D` states, `M` Brownian motions.
#[derive(Debug)]
pub struct Simulation<S, const D: usize, const M: usize> {
    pub(crate) system: S,
    pub(crate) solver: Solver<D>,
}

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// Lays the particles on their lattice and gives them their masses and smoothing lengths, at `t = 0`.
    ///
    /// # Errors
    /// Any parameter outside its range, by name; [`Error::TooFewParticles`]; [`Error::SupportTooSmall`] where the
    /// estimator is known to fail at the resolution asked for; [`Error::NoLinearPart`] where the scheme needs one and the
    /// system declares none.
    pub fn new(system: S, law: &GaussianMixture<D>, config: &Config<D>) -> Result<Self, Error> {
        check_linear_part(config.method.combination_in(D).scheme, system.linear_part())?;
        Ok(Self { system, solver: (passes().start)(law, config, None)? })
    }

    /// As [`Self::new`], with an estimator of the caller's in place of the method's.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_estimator(
        system: S,
        law: &GaussianMixture<D>,
        config: &Config<D>,
        estimator: Box<dyn ScoreEstimator<D> + Sync>,
    ) -> Result<Self, Error> {
        check_linear_part(config.method.combination_in(D).scheme, system.linear_part())?;
        Ok(Self { system, solver: (passes().start)(law, config, Some(estimator))? })
    }

    /// Time of the state.
    pub fn time(&self) -> f64 {
        self.solver.state.time
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// Number of particles.
    pub fn n_particles(&self) -> usize {
        self.solver.n_particles()
    }

    /// Positions, in the units of the state.
    pub fn positions(&self) -> &[[f64; D]] {
        &self.solver.state.positions
    }

    /// Masses: the probability that each particle carries. Their sum falls short of 1 by what lies beyond the lattice.
    pub fn masses(&self) -> &[f64] {
        &self.solver.state.masses
    }

    /// Steps, evaluations and neighbour visits so far.
    pub fn work(&self) -> Work {
        self.solver.work()
    }

    /// Errors of mean and covariance of the particles, from what they violate of the moment equations of the system: the particles'
    /// less those of the density, propagated by the linear regression of the drift.
    ///
    /// It sees what all lattices share, such as what lies beyond their reach and waves that settle. The error of the steps in time
    /// is not in it.
    pub fn moment_errors(&self) -> MeanAndCovariance<D> {
        self.solver.balance.errors
    }

    /// The affine map that takes [`Self::moment_errors`] out of the particles, to first order: the difference that it makes to a
    /// quantity estimates its error. None where the particles have no extent along an axis.
    pub fn moment_correction(&self) -> Option<Correction<D>> {
        self.solver.balance.errors.correction(self.positions(), self.masses())
    }

    /// Number of remeshings so far.
    pub fn n_remaps(&self) -> u64 {
        self.solver.state.n_remaps
    }

    /// One step of the rule's own length.
    ///
    /// # Errors
    /// [`Error::StepCollapsed`], [`Error::StepExceedsDiffusionLimit`], [`Error::WorkLimit`], those of the metric and of
    /// the estimator, and of [`remap`](Self::remap); [`Error::TooMuchUnresolved`] above
    /// [`MOST_UNRESOLVED`](crate::MOST_UNRESOLVED); [`Error::LeftStableRange`] where a particle is no longer finite. The
    /// state is then that before the step, or that after the remeshing before it.
    pub fn step(&mut self) -> Result<StepReport, Error> {
        self.step_towards(f64::INFINITY)
    }

    /// One step, not beyond `end`: `dX/dt = v` (eq 14) by the method's scheme, then `h` by eq 20. Before it the
    /// cloud is remeshed, where the method has a [`Remapping`] and the cloud is too uneven.
    ///
    /// # Errors
    /// As [`Self::step`]; [`Error::TimeInThePast`] unless `end` lies ahead.
    pub fn step_towards(&mut self, end: f64) -> Result<StepReport, Error> {
        let (n, system) = (self.n_particles(), OfSystem(&self.system));
        in_pool(n, || (passes().step_towards)(&mut self.solver, &system, end))
    }

    /// Steps to the given time, landing on it exactly.
    ///
    /// # Errors
    /// Those of [`Self::step`]; [`Error::TimeInThePast`].
    pub fn advance_to(&mut self, time: f64) -> Result<(), Error> {
        self.advance_while(time, |_| true)
    }

    /// Steps to the given time as [`advance_to`](Self::advance_to) does, while `goes_on` returns true, which is called before each
    /// step with the present time. A further call continues bitwise identically.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_while(
        &mut self,
        time: f64,
        mut goes_on: impl FnMut(f64) -> bool + Send,
    ) -> Result<(), Error> {
        let (n, system) = (self.n_particles(), OfSystem(&self.system));
        in_pool(n, || (passes().advance_while)(&mut self.solver, &system, time, &mut goes_on))
    }

    /// Runs through the given times, which must not decrease, and calls `observe` at each.
    ///
    /// # Errors
    /// Those of [`Self::advance_to`] and of the observer.
    pub fn run<E: From<Error>>(
        &mut self,
        times: &[f64],
        mut observe: impl FnMut(&Self) -> Result<(), E>,
    ) -> Result<(), E> {
        for &time in times {
            self.advance_to(time)?;
            observe(self)?;
        }
        Ok(())
    }

    /// Remaps the cloud onto a new lattice, whatever its unevenness:
    ///
    /// * a lattice in whitened coordinates, with the spacing of the start, over all cells that carry enough;
    /// * the logarithm of the density there, by moving least squares of its departure from the cloud's Gaussian over the
    ///   lattice as it was, up to half a spacing beyond the last particle, and linearly from there;
    /// * masses `psi dV`, rescaled to the mass of the cloud, and an affine map that restores its mean and covariance.
    ///
    /// A Gaussian is unchanged within roundoff.
    ///
    /// # Errors
    /// [`Error::NotPositive`] and [`Error::NotFinite`] for the parameters, [`Error::NotWhitened`],
    /// [`Error::RemappingTooLarge`], [`Error::RemappingChangesMass`], [`Error::TooFewParticles`], those of the metric and of
    /// the estimator. The simulation is then as it was.
    pub fn remap(&mut self, remapping: &Remapping) -> Result<Remapped, Error> {
        (passes().remap)(&mut self.solver, remapping)
    }

    /// Writes the state and its lattice; reading restores both bitwise.
    ///
    /// # Errors
    /// [`Error::Store`] where the writer fails.
    pub fn snapshot(&self, mut writer: impl Write) -> Result<(), Error> {
        (passes().snapshot)(&self.solver, &mut writer)
    }

    /// Takes state and lattice from a snapshot of a simulation with the same configuration; the run goes on bit for bit.
    /// With a scheme of two steps the snapshot holds the positions (leap-frog) or rates (Adams-Bashforth) of one step ago; a
    /// snapshot without them starts the scheme anew.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`], [`Error::SnapshotWithoutTime`], [`Error::SnapshotNumber`], [`Error::Store`]; the state is
    /// then as it was.
    pub fn restore(&mut self, mut reader: impl Read) -> Result<(), Error> {
        (passes().restore)(&mut self.solver, &mut reader)
    }

    /// The density as a function, over the deformed cells of the flow map at the present positions.
    ///
    /// # Errors
    /// [`Error::NoFlowMap`] for an estimator that follows none; those of the metric.
    pub fn cell_integral(&self) -> Result<CellIntegral<D>, Error> {
        (passes().cell_integral)(&self.solver)
    }

    /// The density as a function of the state, by the method's own estimator at the present positions.
    ///
    /// # Errors
    /// Those of the metric and of the estimator; [`Error::NoLatticeCell`]; [`Error::LeftStableRange`] for a
    /// particle whose lattice cell has no volume.
    pub fn density_field(&self) -> Result<DensityField<D>, Error> {
        (passes().density_field)(&self.solver)
    }
}

/// Refuses a system without the linear part that the scheme needs, and one that is not finite.
fn check_linear_part<const D: usize>(
    scheme: Scheme,
    linear: Option<Matrix<D>>,
) -> Result<(), Error> {
    match linear {
        None if scheme.needs_linear_part() => Err(Error::NoLinearPart { scheme }),
        None => Ok(()),
        Some(part) => part
            .as_flattened()
            .iter()
            .try_for_each(|value| finite("an entry of the linear part of the drift", *value)),
    }
}
