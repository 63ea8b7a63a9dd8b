//! The method on one cloud of particles: everything of a simulation but its system.
//!
//! [`Solver`] owns the discretisation, the state, and the buffers of an evaluation and of a step. What is here evaluates the
//! right-hand side, finds the length of a step, and saves and restores the state. It calls a system through its coefficients
//! alone, and knows neither the step nor the remapping, which are written on it.

pub(crate) mod discretisation;
pub(crate) mod evaluation;
pub(crate) mod moment_balance;
pub(crate) mod report;
mod snapshot;
pub(crate) mod step_length;

use sde_integrators::GaussianMixture;

use self::discretisation::Discretisation;
use self::evaluation::Evaluation;
use self::moment_balance::MomentBalance;
use self::report::Work;
use crate::cloud::lattice::ParticleLattice;
use crate::cloud::start::{Start, initial_spacing};
use crate::error::{Error, positive};
use crate::method::config::{COLLAPSED_STEP, Config};
use crate::score::ScoreEstimator;
use crate::time::Stages;
use crate::time::smoothing::Smoothing;
use crate::time::state::State;

/// The method on one cloud of particles. It is compiled once for each dimension, whatever the system.
#[derive(Debug)]
pub(crate) struct Solver<const D: usize> {
    pub(crate) discretisation: Discretisation<D>,
    pub(crate) reference_period: f64,
    pub(crate) shortest_step: f64,
    pub(crate) longest_step: f64,
    pub(crate) most_steps: u64,
    /// Particles at the start.
    pub(crate) n_start: usize,
    pub(crate) state: State<D>,
    pub(crate) balance: MomentBalance<D>,
    pub(crate) evaluation: Evaluation<D>,
    pub(crate) stages: Stages<D>,
    /// Volumes at the first stage of a step, and what follows from them.
    pub(crate) smoothing: Smoothing,
}

impl<const D: usize> Solver<D> {
    /// Particles on the lattice of the configuration at `t = 0`, with their masses and smoothing lengths.
    pub(crate) fn new(
        law: &GaussianMixture<D>,
        config: &Config<D>,
        estimator: Box<dyn ScoreEstimator<D> + Sync>,
    ) -> Result<Self, Error> {
        let combination = config.method.combination_in(D);
        combination.check()?;
        positive("reference_period", config.reference_period)?;
        // Shorter periods have no shortest step.
        positive("a millionth of reference_period", COLLAPSED_STEP * config.reference_period)?;
        estimator.check_resolution(combination.support_over_spacing)?;
        let start = Start::new(law, &config.lattice)?;
        let spacing = initial_spacing(&start, combination.metric)?;
        let n = start.positions.len();
        let h = combination.support_over_spacing * spacing / estimator.support();
        let lattice = ParticleLattice::default();
        let of_law = (law.mean(), law.covariance());
        let balance = MomentBalance::new(of_law, &start.positions, &start.masses);
        let mut solver = Self {
            discretisation: Discretisation { estimator, combination, lattice },
            reference_period: config.reference_period,
            shortest_step: COLLAPSED_STEP * config.reference_period,
            longest_step: combination.step.longest(config.reference_period),
            most_steps: config.most_steps,
            n_start: n,
            state: State {
                time: 0.0,
                n_steps: 0,
                n_remaps: 0,
                positions: start.positions,
                masses: start.masses,
                smoothing_lengths: vec![h; n],
                smoothing_ratios: vec![0.0; n],
                previous: None,
            },
            balance,
            evaluation: Evaluation::new(n),
            stages: Stages::new(n),
            smoothing: Smoothing::new(n),
        };
        solver.discretisation.lay(ParticleLattice::new(start.indices, spacing))?;
        solver.start_smoothing_lengths(h)?;
        Ok(solver)
    }

    /// Sets `h_0i` and the product that eq 20 keeps.
    pub(crate) fn start_smoothing_lengths(&mut self, h: f64) -> Result<(), Error> {
        let Self { discretisation, state, evaluation, .. } = self;
        evaluation.estimate(discretisation, state, state.stage())?;
        for (ratio, volume) in state.smoothing_ratios.iter_mut().zip(&evaluation.estimates.volume) {
            *ratio = h / volume.powf(1.0 / D as f64);
        }
        Ok(())
    }

    /// Buffers for as many particles as the state holds.
    pub(crate) fn resize_buffers(&mut self) {
        let n = self.n_particles();
        if self.stages.x.len() != n {
            let work = self.evaluation.work;
            self.evaluation = Evaluation::new(n);
            self.evaluation.work = work;
            (self.stages, self.smoothing) = (Stages::new(n), Smoothing::new(n));
        }
    }

    pub(crate) fn n_particles(&self) -> usize {
        self.state.positions.len()
    }

    /// Steps, evaluations and neighbour visits so far.
    pub(crate) fn work(&self) -> Work {
        Work { steps: self.state.n_steps, ..self.evaluation.work }
    }

    /// The probability that no particle carries, at most.
    pub(crate) fn mass_outside(&self) -> f64 {
        let total: f64 = self.state.masses.iter().sum();
        let remapping = self.discretisation.combination.remapping.as_ref();
        let outermost_mass = remapping.map_or(0.0, |remapping| remapping.outermost_mass);
        (1.0 - total).abs() + self.state.n_remaps as f64 * outermost_mass
    }

    /// Refuses a time before the present one.
    pub(crate) fn check_not_past(&self, time: f64) -> Result<(), Error> {
        if !time.is_finite() || time < self.state.time {
            return Err(Error::TimeInThePast { value: time, now: self.state.time });
        }
        Ok(())
    }

    /// An evaluation at the present state, apart from the buffers of the steps.
    pub(crate) fn evaluated(&self) -> Result<Evaluation<D>, Error> {
        let (state, mut evaluation) = (&self.state, Evaluation::new(self.n_particles()));
        evaluation.estimate(&self.discretisation, state, state.stage())?;
        Ok(evaluation)
    }
}
