//! First passage by an absorbing boundary: particles carry how much of them has survived.

use sde_integrators::Sde;

use super::absorption::Absorption;
use super::exchange::Scene;
use crate::density::probability::Probability;
use crate::error::{Error, finite};
use crate::simulation::Simulation;
use crate::solver::Solver;
use crate::system::coefficients::{Coefficients, OfSystem};

/// The probability that a demand `y` has passed thresholds `T_k` by now, all from one run of a [`Simulation`], which it
/// watches and does not change.
///
/// Let `psi` be the density and `psi_a` the density of the paths that have stayed below `T`. Both obey the
/// Fokker-Planck-Kolmogorov equation; the survival `w = psi_a / psi`, along the particles, which move with
/// `v = f - div D - D grad log psi`, obeys
///
/// $$ \frac{Dw}{Dt} = \frac{1}{\psi} \nabla \cdot (\psi D \nabla w), \qquad 0 \le w \le 1, $$
///
/// with `w = 1` at the start and `w = 0` beyond the threshold. A particle that goes beyond gives up its surviving mass
/// `mu_i w_i`, and comes back with `w = 0`: that nobody comes in is the boundary condition of `psi_a`. Then
///
/// $$ P\left( \max_{s \le t} y(s) > T \right) = \sum_i \mu_i (1 - w_i) . $$
///
/// * Diffusion: particles exchange surviving mass with those near them on the lattice of the start, along the noise only.
///   Surviving and absorbed mass together are conserved, and every `w` stays within `[0, 1]`.
/// * Noise that acts on the demand itself carries survivors beyond the threshold between two particles: there `w = 0` at
///   the place where the threshold cuts the move (Gibou et al. 2002). Noise that does not, as on the velocity of an
///   oscillator with a limit of displacement, exchanges nothing across the threshold.
/// * Time: half an exchange before the step's motion and half after it (Strang 1968). An excursion within a step or
///   two is found by the parabola through three records: without it `P` of the damper is 2.6 % lower at 40 steps a period.
///
/// Errors: that of the density, that of a threshold between layers of particles, and numerical diffusion across the noise.
/// All fall with the spacing; compare two resolutions. Mass that lay beyond the lattice at the start is not in it:
/// [`Self::probability`] says where that is as large as the probability.
/// Works with every method, since every method starts on a lattice, but not across a fresh one: what has survived is not
/// carried over. The source is this project.
///
/// A general limit state `g(x) > 0` is the demand `g` with the threshold 0.
///
/// ```
/// # use vibrating_systems::{LinearOscillator, LinearOscillatorParameters, Window};
/// # use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};
/// # use sde_integrators::GaussianMixture;
/// use fpk_sph::observables::FirstPassage;
/// # let system = LinearOscillator::new(LinearOscillatorParameters {
/// #     natural_frequency: std::f64::consts::TAU,
/// #     damping_ratio: 0.05,
/// #     noise_intensity: 1.0,
/// #     window: Window::Stationary,
/// # })?;
/// # let law = GaussianMixture::independent([0.0; 2], [0.05, 0.3])?;
/// # let config = Config {
/// #     method: Method::FlowMapFit,
/// #     lattice: InitialLattice::box_of(21),
/// #     reference_period: 1.0,
/// #     most_steps: DEFAULT_MOST_STEPS,
/// # };
/// let mut simulation = Simulation::new(system, &law, &config)?;
/// let mut passage = FirstPassage::new(&simulation, |x| x[0].abs(), &[0.4, 0.6])?;
/// passage.advance_to(&mut simulation, 2.0)?;
/// let [lower, higher] = passage.probabilities() else { unreachable!() };
/// assert!(0.0 < *higher && higher < lower && *lower < 1.0);
/// # Ok::<(), fpk_sph::Error>(())
/// ```
pub struct FirstPassage<F, const D: usize> {
    demand: F,
    absorption: Absorption<D>,
}

impl<F, const D: usize> std::fmt::Debug for FirstPassage<F, D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FirstPassage")
            .field("thresholds", &self.absorption.thresholds)
            .field("time", &self.absorption.time)
            .field("absorbed", &self.absorption.absorbed)
            .finish_non_exhaustive()
    }
}

impl<F: Fn(&[f64; D]) -> f64, const D: usize> FirstPassage<F, D> {
    /// Begins to watch: what is beyond a threshold now has passed it.
    ///
    /// # Errors
    /// [`Error::TooFewRows`] without a threshold; [`Error::NotFinite`] for a threshold or a demand;
    /// [`Error::NoLatticeCell`] for a particle that has no neighbour on the lattice.
    pub fn new<S: Sde<D, M>, const M: usize>(
        simulation: &Simulation<S, D, M>,
        demand: F,
        thresholds: &[f64],
    ) -> Result<Self, Error> {
        let Simulation { system, solver } = simulation;
        let mut passage = Self { demand, absorption: Absorption::new(solver, thresholds)? };
        passage.look(solver, &OfSystem(system))?;
        passage.absorption.begin(&solver.state.masses);
        Ok(passage)
    }

    /// Steps the simulation to a time, recording every step.
    ///
    /// # Errors
    /// Those of [`Simulation::advance_to`] and of [`Self::record`].
    pub fn advance_to<S: Sde<D, M>, const M: usize>(
        &mut self,
        simulation: &mut Simulation<S, D, M>,
        time: f64,
    ) -> Result<(), Error> {
        let Simulation { system, solver } = simulation;
        let system = &OfSystem(system);
        solver.check_not_past(time)?;
        while solver.state.time < time {
            let _report = solver.step_towards(system, time)?;
            self.record_step(solver, system)?;
        }
        Ok(())
    }

    /// Records the simulation after a step. It must be the simulation given at construction, and no step may be
    /// omitted; a step already recorded changes nothing.
    ///
    /// # Errors
    /// [`Error::UnwatchedSteps`]; [`Error::OtherSimulation`]; [`Error::RemappedUnderWatch`]; [`Error::NotFinite`] for a demand; [`Error::LeftStableRange`]
    /// where a cell has no volume. Earlier records are kept.
    pub fn record<S: Sde<D, M>, const M: usize>(
        &mut self,
        simulation: &Simulation<S, D, M>,
    ) -> Result<(), Error> {
        self.record_step(&simulation.solver, &OfSystem(&simulation.system))
    }

    fn record_step(
        &mut self,
        solver: &Solver<D>,
        system: &dyn Coefficients<D>,
    ) -> Result<(), Error> {
        if !self.absorption.has_recorded(solver)? {
            self.look(solver, system)?;
            self.absorption.record(&solver.state);
        }
        Ok(())
    }

    /// Demands and exchange where the particles are now, into the buffers.
    fn look(&mut self, solver: &Solver<D>, system: &dyn Coefficients<D>) -> Result<(), Error> {
        let (x, t) = (&solver.state.positions, solver.state.time);
        let scratch = &mut self.absorption.scratch;
        for (value, x) in scratch.value.iter_mut().zip(x) {
            *value = (self.demand)(x);
            finite("demand", *value)?;
        }
        let scene = Scene {
            positions: x,
            masses: &solver.state.masses,
            lattice: &solver.discretisation.lattice.axis_neighbours,
            at: (solver.state.n_steps, t),
        };
        system.noise(t, x, &mut scratch.noise);
        scratch.exchange.find(&scene, &scratch.noise, &self.demand)
    }

    /// The thresholds, in the order given.
    pub fn thresholds(&self) -> &[f64] {
        &self.absorption.thresholds
    }

    /// `P(max y > T_k)` over the time watched, in the order of the thresholds; what each rests on:
    /// [`probability`](Self::probability).
    pub fn probabilities(&self) -> &[f64] {
        &self.absorption.absorbed
    }

    /// The probability of the threshold `k` with what it rests on. `None` where there is no such threshold.
    ///
    /// A probability of 0 is [`Probability::Below`] what the lattice left outside at the start. Not resolved is what came
    /// from particles whose cells were turned over when they passed.
    pub fn probability(&self, k: usize) -> Option<Probability> {
        let Absorption { absorbed, unresolved, mass_outside, .. } = &self.absorption;
        Some(Probability::of(*absorbed.get(k)?, unresolved[k], 0.0, *mass_outside))
    }

    /// `w_i` of every particle for the threshold `k`: the part of its mass that has stayed below. `None` where there is no
    /// such threshold.
    pub fn survival(&self, k: usize) -> Option<&[f64]> {
        self.absorption.survival.get(k).map(Vec::as_slice)
    }
}
