//! A simulation as a value: checked once, stepped, observed, saved and restored.

use std::io::{Read, Write};

use particle_store::{Attribute, ParticleStore};
use sde_integrators::{GaussianMixture, Sde};

use crate::cloud::AxisNeighbours;
use crate::error::{Error, positive};
use crate::lattice::{ParticleLattice, index_of_place};
use crate::method::{Combination, InitialSmoothing, Method, StepRule};
use crate::metric::{Metric, Whitening};
use crate::report::Work;
use crate::score::{
    LocalFit, LocalMap, LogDensityFit, ScoreEstimator, determinant, lattice_jacobian,
};
use crate::stage::{Field, Stage};
use crate::start::{InitialLattice, Start, initial_spacing};
use crate::step::Stages;

/// What a simulation needs to know besides the system and its initial law.
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

/// The density of a system on moving particles (Canor & Denoël 2013, eq 11-14):
///
/// $$ \frac{dX}{dt} = v = f - \nabla\cdot D - D \nabla\log\psi, $$
///
/// with masses that never change. `D` states, `M` Brownian motions.
#[derive(Debug)]
pub struct Simulation<S, const D: usize, const M: usize> {
    pub(crate) field: Field<S, D>,
    pub(crate) reference_period: f64,
    pub(crate) shortest_step: f64,
    pub(crate) longest_step: f64,
    pub(crate) most_steps: u64,
    /// Particles at the start.
    n_start: usize,
    pub(crate) state: State<D>,
    pub(crate) stage: Stage<D>,
    pub(crate) stages: Stages<D>,
}

/// What a step changes; all that a snapshot must hold.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State<const D: usize> {
    pub(crate) time: f64,
    pub(crate) n_steps: u64,
    pub(crate) n_remaps: u64,
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) masses: Vec<f64>,
    /// `h_i`, in the coordinates of the metric.
    pub(crate) smoothing_lengths: Vec<f64>,
    /// `h_0i / V_0i^(1/D)`, the product that eq 20 keeps.
    pub(crate) smoothing_ratios: Vec<f64>,
    /// What a scheme of two steps remembers; none before its first.
    pub(crate) previous: Option<Previous<D>>,
}

/// The state one step ago.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Previous<const D: usize> {
    pub(crate) positions: Vec<[f64; D]>,
    /// The step from there to the present state.
    pub(crate) dt: f64,
}

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// Lays the particles on their lattice and gives them their masses and smoothing lengths, at `t = 0`.
    ///
    /// # Errors
    /// Any parameter outside its range, by name; [`Error::TooFewParticles`]; [`Error::SupportTooSmall`] where the
    /// estimator is known to fail at the resolution asked for.
    pub fn new(system: S, law: &GaussianMixture<D>, config: &Config<D>) -> Result<Self, Error> {
        let estimator = config.method.combination_in(D).estimator.build();
        Self::with_estimator(system, law, config, estimator)
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
        let mut simulation = Self {
            field: Field { system, estimator, combination, lattice: ParticleLattice::default() },
            reference_period: config.reference_period,
            shortest_step: COLLAPSED_STEP * config.reference_period,
            longest_step: longest_step(&combination, config.reference_period),
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
            stage: Stage::new(n),
            stages: Stages::new(n),
        };
        simulation.field.lay(ParticleLattice::new(start.indices, spacing))?;
        simulation.start_smoothing_lengths(h, spacing)?;
        Ok(simulation)
    }

    /// Sets `h_0i` and the product that eq 20 keeps.
    pub(crate) fn start_smoothing_lengths(&mut self, h: f64, spacing: f64) -> Result<(), Error> {
        let Self { field, state, stage, .. } = self;
        match field.combination.initial_smoothing {
            InitialSmoothing::Uniform => {
                stage.estimate(field, state, 0.0, &state.positions)?;
                for (ratio, volume) in state.smoothing_ratios.iter_mut().zip(&stage.volume) {
                    *ratio = h / volume.powf(1.0 / D as f64);
                }
            }
            InitialSmoothing::Iterated => {
                state.smoothing_ratios.fill(h / spacing);
                for _ in 0..MOST_SMOOTHING_ITERATIONS {
                    stage.estimate(field, state, 0.0, &state.positions)?;
                    if state.update_smoothing_lengths(&stage.volume) < SMOOTHING_TOLERANCE {
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Time of the state.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.field.system
    }

    /// Number of particles.
    pub fn n_particles(&self) -> usize {
        self.state.positions.len()
    }

    /// Positions, in the units of the state.
    pub fn positions(&self) -> &[[f64; D]] {
        &self.state.positions
    }

    /// Masses: the probability that each particle carries. Their sum falls short of 1 by what lies beyond the lattice.
    pub fn masses(&self) -> &[f64] {
        &self.state.masses
    }

    /// Steps, evaluations and neighbour visits so far.
    pub fn work(&self) -> Work {
        Work { steps: self.state.n_steps, ..self.stage.work }
    }

    /// Steps to the given time, landing on it exactly.
    ///
    /// # Errors
    /// Those of [`Self::step`]; [`Error::TimeInThePast`].
    pub fn advance_to(&mut self, time: f64) -> Result<(), Error> {
        if !time.is_finite() || time < self.state.time {
            return Err(Error::TimeInThePast { value: time, now: self.state.time });
        }
        while self.state.time < time {
            let _report = self.step_towards(time)?;
        }
        Ok(())
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

    /// Writes the state with the lattice that it stands on, bit for bit.
    ///
    /// # Errors
    /// [`Error::Store`] where the writer fails.
    pub fn snapshot(&self, writer: impl Write) -> Result<(), Error> {
        let mut store = ParticleStore::<D>::new(self.n_particles());
        let State {
            time,
            n_steps,
            n_remaps,
            positions,
            masses,
            smoothing_lengths,
            smoothing_ratios,
            previous,
        } = &self.state;
        store.add("position", positions.clone())?;
        store.add("place", self.field.lattice.places.clone())?;
        store.add("mass", masses.clone())?;
        store.add("smoothing_length", smoothing_lengths.clone())?;
        store.add("smoothing_ratio", smoothing_ratios.clone())?;
        store.set_attribute("time", Attribute::Real(*time));
        store.set_attribute("n_steps", Attribute::Count(*n_steps));
        if let Some(Previous { positions, dt }) = previous {
            store.add("previous_position", positions.clone())?;
            store.set_attribute("previous_dt", Attribute::Real(*dt));
        }
        store.set_attribute("n_remaps", Attribute::Count(*n_remaps));
        store.set_attribute("n_start", Attribute::Count(self.n_start as u64));
        store.snapshot(writer)?;
        Ok(())
    }

    /// Takes state and lattice from a snapshot of a simulation with the same configuration; the run goes on bit for bit.
    /// With leap-frog the snapshot holds the positions of one step ago; a snapshot without them starts it anew.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`], [`Error::SnapshotWithoutTime`], [`Error::SnapshotNumber`], [`Error::Store`]; the state is
    /// then as it was.
    pub fn restore(&mut self, reader: impl Read) -> Result<(), Error> {
        let store = ParticleStore::<D>::restore(reader)?;
        let count = |name: &str| match store.attribute(name) {
            Some(Attribute::Count(count)) => Ok(count),
            _ => Err(Error::SnapshotWithoutTime),
        };
        let Some(Attribute::Real(time)) = store.attribute("time") else {
            return Err(Error::SnapshotWithoutTime);
        };
        let (n_steps, n_remaps) = (count("n_steps")?, count("n_remaps")?);
        // The same start; as many particles as at the start where no fresh lattice was laid.
        let found = if n_remaps == 0 { store.len() as u64 } else { count("n_start")? };
        if store.is_empty() {
            return Err(Error::ForeignSnapshot { found: 0, expected: self.n_start });
        }
        if found != self.n_start as u64 {
            let found = usize::try_from(found).unwrap_or(usize::MAX);
            return Err(Error::ForeignSnapshot { found, expected: self.n_start });
        }
        let column = |name: &str| -> Result<Vec<f64>, Error> {
            Ok(store.get(store.handle(name)?)?.to_vec())
        };
        let points = |name: &str| -> Result<Vec<[f64; D]>, Error> {
            Ok(store.get(store.handle(name)?)?.to_vec())
        };
        let previous = match store.attribute("previous_dt") {
            Some(Attribute::Real(dt)) => {
                Some(Previous { positions: points("previous_position")?, dt })
            }
            _ => None,
        };
        let state = State {
            time,
            n_steps,
            n_remaps,
            positions: points("position")?,
            masses: column("mass")?,
            smoothing_lengths: column("smoothing_length")?,
            smoothing_ratios: column("smoothing_ratio")?,
            previous,
        };
        let places = store.get(store.handle::<[f64; D]>("place")?)?;
        state.check_restored(places)?;
        if places != self.field.lattice.places {
            let indices = places.iter().map(index_of_place).collect();
            self.field.lay(ParticleLattice::new(indices, self.field.lattice.spacing))?;
        }
        self.state = state;
        self.fit_buffers();
        Ok(())
    }
}

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// An evaluation at the present state, apart from the buffers of the steps.
    pub(crate) fn evaluated(&self) -> Result<Stage<D>, Error> {
        let mut stage = Stage::new(self.n_particles());
        stage.estimate(&self.field, &self.state, self.state.time, &self.state.positions)?;
        Ok(stage)
    }

    /// The flow map around every particle, where the estimator follows it.
    pub(crate) fn local_maps(&self) -> Result<Option<(Stage<D>, Vec<LocalMap<D>>)>, Error> {
        let Self { field, state, .. } = self;
        if field.estimator.criterion().is_some() {
            return Ok(None);
        }
        let mut stage = Stage::new(self.n_particles());
        stage.find_neighbours(field, state, state.time, &state.positions)?;
        let maps = field.estimator.local_maps(&stage.cloud(field, state, state.time));
        Ok(maps.map(|maps| (stage, maps)))
    }

    /// Local fits of log density in whitened coordinates, whatever the method: with the method's own smoothing lengths
    /// where it whitens, else with lengths that hold as many neighbours as the method's support at the start.
    pub(crate) fn local_fits(&self) -> Result<(Stage<D>, Vec<LocalFit<D>>), Error> {
        let fit = LogDensityFit::default();
        let combination = Method::LogDensityFit.combination();
        let field = Field {
            system: (),
            estimator: Box::new(fit),
            combination,
            lattice: self.field.lattice.clone(),
        };
        let mut state = self.state.clone();
        let mut stage = Stage::new(self.n_particles());
        if self.field.combination.metric == Metric::Isotropic {
            let support = <LogDensityFit as ScoreEstimator<D>>::support(&fit);
            state.whitened_smoothing_lengths(
                &field.lattice.axis_neighbours,
                combination.support_over_spacing / support,
            )?;
        }
        stage.find_neighbours(&field, &state, state.time, &state.positions)?;
        let fits = fit.local_fits(&stage.cloud(&field, &state, state.time))?;
        Ok((stage, fits))
    }
}

/// All coordinates, each with the number of its point.
fn coordinates<const D: usize>(points: &[[f64; D]]) -> impl Iterator<Item = (usize, f64)> {
    points.iter().enumerate().flat_map(|(i, point)| point.iter().map(move |&value| (i, value)))
}

impl<const D: usize> State<D> {
    /// Whether numbers out of a snapshot are such as a simulation has.
    fn check_restored(&self, places: &[[f64; D]]) -> Result<(), Error> {
        let fits = |quantity, particle, value: f64, is_right: bool, must| {
            let error = Error::SnapshotNumber { quantity, particle, value, must };
            if is_right { Ok(()) } else { Err(error) }
        };
        fits("time", 0, self.time, self.time.is_finite(), "finite")?;
        for (i, &mass) in self.masses.iter().enumerate() {
            fits("mass", i, mass, mass.is_finite(), "finite")?;
        }
        let before = self.previous.as_ref().map_or(&[][..], |previous| &previous.positions);
        for (quantity, points) in [("position", &self.positions[..]), ("previous_position", before)]
        {
            for (i, value) in coordinates(points) {
                fits(quantity, i, value, value.is_finite(), "finite")?;
            }
        }
        for (i, value) in coordinates(places) {
            // No place is as far out as where indices end.
            let is_right = value.fract() == 0.0 && value.abs() < f64::from(i32::MAX);
            fits("place", i, value, is_right, "a whole number of 31 bits")?;
        }
        let dt = self.previous.as_ref().map_or(1.0, |previous| previous.dt);
        fits("previous_dt", 0, dt, dt > 0.0 && dt.is_finite(), "above 0 and finite")
    }

    /// Keeps the present positions for the step after one of length `dt`.
    pub(crate) fn remember(&mut self, dt: f64) {
        match &mut self.previous {
            Some(previous) => {
                previous.positions.copy_from_slice(&self.positions);
                previous.dt = dt;
            }
            None => self.previous = Some(Previous { positions: self.positions.clone(), dt }),
        }
    }

    /// Smoothing lengths in whitened coordinates from the deformed lattice.
    fn whitened_smoothing_lengths(
        &mut self,
        lattice: &[AxisNeighbours<D>],
        ratio: f64,
    ) -> Result<(), Error> {
        let at = (self.n_steps, self.time);
        let whitening = Whitening::of(Metric::Whitened, &self.positions, &self.masses, at)?;
        for (i, h) in self.smoothing_lengths.iter_mut().enumerate() {
            let edges = lattice_jacobian(&self.positions, lattice, i)
                .ok_or(Error::NoLatticeCell { particle: i })?;
            *h = ratio * (determinant(&edges).abs() / whitening.determinant()).powf(1.0 / D as f64);
        }
        Ok(())
    }

    /// `h_i = h_0i (V_i / V_0i)^(1/D)` (eq 20), and the largest relative change.
    pub(crate) fn update_smoothing_lengths(&mut self, volume: &[f64]) -> f64 {
        let mut largest_change = 0.0_f64;
        for ((h, ratio), volume) in
            self.smoothing_lengths.iter_mut().zip(&self.smoothing_ratios).zip(volume)
        {
            let updated = ratio * volume.powf(1.0 / D as f64);
            largest_change = largest_change.max((updated / *h - 1.0).abs());
            *h = updated;
        }
        largest_change
    }
}

/// The longest step that a rule allows, whatever the limits.
fn longest_step(combination: &Combination, reference_period: f64) -> f64 {
    match combination.step {
        StepRule::Courant { .. } => f64::INFINITY,
        StepRule::Fixed { dt } => dt,
        StepRule::DiffusionLimited { longest } => longest,
        StepRule::PeriodFraction { steps_per_period } => reference_period / steps_per_period,
    }
}

/// Relative change of smoothing lengths at which their iteration has settled: well below what changes a neighbour list.
const SMOOTHING_TOLERANCE: f64 = 1e-3;
/// The iteration contracts by about a half each time; what is left after this many is carried on by eq 20.
const MOST_SMOOTHING_ITERATIONS: usize = 30;
