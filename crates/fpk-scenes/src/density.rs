//! A run of the density solver, observed at given times.

use fpk_sph::observables::{CellIntegral, Probability};
use fpk_sph::{ConditionedSimulation, Config, Correction, Error, Simulation, Work};
use scene_runs::clock::CpuClock;
use sde_integrators::{Additive, GaussianMixture, NoiseClass, Sde};
use serde::{Deserialize, Serialize};

use crate::kinks::stops_before;

/// Requested results of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Requested<const D: usize = 2> {
    /// Times of observation.
    pub times: Vec<f64>,
    /// Raw moments `E[x_1^a_1 .. x_D^a_D]`.
    pub powers: Vec<[u32; D]>,
    /// Demand compared with the thresholds.
    pub demand: Demand,
    /// Thresholds `T` of `P(|y| > T)` for the demand `y`.
    pub thresholds: Vec<f64>,
    /// Times at which the noise has a kink, in increasing order: a step ends at each, since one across it loses its order.
    pub kinks: Vec<f64>,
    /// Whether to integrate over the particles' cells, which requires a flow map.
    pub cells: bool,
}

/// A weighted sum of the states, compared in magnitude.
#[derive(Debug, Clone, PartialEq)]
pub struct Demand {
    /// Its name.
    pub name: String,
    /// Weight of each state.
    pub weights: Vec<f64>,
}

impl Demand {
    /// The demand on one state.
    #[must_use]
    pub fn of_state(state: usize, name: &str, n_states: usize) -> Self {
        let weights = (0..n_states).map(|k| f64::from(u8::from(k == state))).collect();
        Self { name: name.to_owned(), weights }
    }

    /// `|q|` of an oscillator `(q, v)`.
    #[must_use]
    pub fn displacement() -> Self {
        Self::of_state(0, "q", 2)
    }

    /// Evaluates `|y(x)|`.
    #[must_use]
    pub fn magnitude<const D: usize>(&self, x: &[f64; D]) -> f64 {
        self.weights.iter().zip(x).map(|(weight, x)| weight * x).sum::<f64>().abs()
    }
}

/// Three estimates of an exceedance probability.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exceedances {
    /// Sum of the masses beyond the threshold (eq 25).
    pub indicator: f64,
    /// From the log-interpolated distribution.
    pub log_interpolated: f64,
    /// Integral over deformed cells; `None` if not requested.
    pub cell_integrated: Option<f64>,
    /// What that integral rests on, in words, where it is less than particles.
    pub note: Option<String>,
    /// The same integral at the neighbouring thresholds [`BESIDE`]: the difference of two runs may change its sign at this one.
    pub beside: Option<[f64; 2]>,
    /// Its error by the moment equations.
    pub offset: f64,
}

/// Ratios of the neighbouring thresholds to a threshold (no unit).
pub const BESIDE: [f64; 2] = [0.85, 1.15];

/// Results at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The time.
    pub t: f64,
    /// Raw moments, in the requested order.
    pub moments: Vec<f64>,
    /// Moments of the absolute values, in the same order: scales of the errors.
    pub scales: Vec<f64>,
    /// Errors of the moments by the moment equations, in the same order.
    pub offsets: Vec<f64>,
    /// Relative error of standard deviations by the moment equations.
    pub violation: f64,
    /// Probabilities, in the order of the thresholds.
    pub exceedances: Vec<Exceedances>,
    /// `sum mu_i`.
    pub total_mass: f64,
    /// Probability that no particle carries, at most.
    pub mass_outside: f64,
    /// Whether the cloud was remeshed.
    pub is_remeshed: bool,
    /// Entropy (nats).
    pub entropy: f64,
    /// Integral of the density over the cells, if requested.
    pub cell_mass: Option<f64>,
    /// CPU time of the solver so far (s), without observation.
    pub cpu_seconds: f64,
}

/// Results of a run.
#[derive(Debug)]
pub struct DensityRun {
    /// One row for each time reached.
    pub rows: Vec<Row>,
    /// Number of particles.
    pub n_particles: usize,
    /// Work counters.
    pub work: Work,
    /// Error that ended the run early, if any.
    pub stopped: Option<Error>,
}

impl DensityRun {
    /// The row of a requested time.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<&Row> {
        self.rows.iter().find(|row| (row.t - t).abs() < 1e-9)
    }

    /// Number of particles, steps and cost, for the method column.
    #[must_use]
    pub fn words(&self, method: &str) -> String {
        let cpu = self.rows.last().map_or(0.0, |row| row.cpu_seconds);
        format!(
            "{method}: {} particles, {} steps, {cpu:.2} s CPU",
            self.n_particles, self.work.steps
        )
    }
}

/// Runs the density solver on a system; `look` observes the simulation at every time.
///
/// A run that ends early is a result: the rows so far, with the reason in [`DensityRun::stopped`].
///
/// # Errors
/// [`Error`] if the run could not start.
pub fn run_on<S: Sde<D, M>, const D: usize, const M: usize>(
    system: S,
    law: &GaussianMixture<D>,
    config: &Config<D>,
    asked: &Requested<D>,
    mut look: impl FnMut(&Simulation<S, D, M>, &Row),
) -> Result<DensityRun, Error> {
    run_from(
        || Simulation::new(system, law, config),
        asked,
        Reached::default(),
        |at| {
            if let Some(row) = at.rows.last() {
                look(at.simulation, row);
            }
        },
        &mut |_| true,
    )
}

/// A simulation whose density a run observes.
pub trait DensitySimulation<S, const D: usize, const M: usize> {
    /// The density.
    fn density(&self) -> &Simulation<S, D, M>;

    /// As [`Simulation::moment_correction`]; none where the moment equations of the states do not close over the particles.
    fn moment_correction(&self) -> Option<Correction<D>>;

    /// As [`Simulation::advance_while`].
    ///
    /// # Errors
    /// Those of the simulation.
    fn advance_while(
        &mut self,
        time: f64,
        goes_on: &mut (dyn FnMut(f64) -> bool + Send),
    ) -> Result<(), Error>;

    /// As [`Simulation::snapshot`], at the end of a list of bytes.
    ///
    /// # Errors
    /// Those of the simulation.
    fn snapshot(&self, bytes: &mut Vec<u8>) -> Result<(), Error>;

    /// As [`Simulation::restore`].
    ///
    /// # Errors
    /// Those of the simulation.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), Error>;
}

impl<S: Sde<D, M>, const D: usize, const M: usize> DensitySimulation<S, D, M>
    for Simulation<S, D, M>
{
    fn density(&self) -> &Simulation<S, D, M> {
        self
    }

    fn moment_correction(&self) -> Option<Correction<D>> {
        Self::moment_correction(self)
    }

    fn advance_while(
        &mut self,
        time: f64,
        goes_on: &mut (dyn FnMut(f64) -> bool + Send),
    ) -> Result<(), Error> {
        Self::advance_while(self, time, goes_on)
    }

    fn snapshot(&self, bytes: &mut Vec<u8>) -> Result<(), Error> {
        Self::snapshot(self, bytes)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        Self::restore(self, bytes)
    }
}

/// The density of the structure, whose filter is conditioned out.
impl<S: Sde<DS, 1, Noise = Additive>, const DS: usize, const DF: usize> DensitySimulation<S, DS, 1>
    for ConditionedSimulation<S, DS, DF>
{
    fn density(&self) -> &Simulation<S, DS, 1> {
        self.structure()
    }

    fn moment_correction(&self) -> Option<Correction<DS>> {
        None
    }

    fn advance_while(
        &mut self,
        time: f64,
        goes_on: &mut (dyn FnMut(f64) -> bool + Send),
    ) -> Result<(), Error> {
        Self::advance_while(self, time, goes_on)
    }

    fn snapshot(&self, bytes: &mut Vec<u8>) -> Result<(), Error> {
        Self::snapshot(self, bytes)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        Self::restore(self, bytes)
    }
}

/// State from which a run resumes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Reached {
    rows: Vec<Row>,
    /// Empty at the start.
    snapshot: Vec<u8>,
    evaluations: u64,
    neighbour_visits: u64,
    cpu_seconds: f64,
}

/// A run at a time of observation, or where it was halted.
pub struct ObservedRun<'a, S, const D: usize, const M: usize> {
    /// The density.
    pub simulation: &'a Simulation<S, D, M>,
    /// Results so far; unless the run was halted, the last row is for this time.
    pub rows: &'a [Row],
    /// Whether it is between two times of observation.
    pub is_halted: bool,
    whole: &'a dyn DensitySimulation<S, D, M>,
    work: Work,
    cpu_seconds: f64,
}

impl<S, const D: usize, const M: usize> std::fmt::Debug for ObservedRun<'_, S, D, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ObservedRun").field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl<S: Sde<D, M>, const D: usize, const M: usize> ObservedRun<'_, S, D, M> {
    /// State from which another run resumes.
    ///
    /// # Errors
    /// Those of [`Simulation::snapshot`].
    pub fn reached(&self) -> Result<Reached, Error> {
        let mut snapshot = Vec::new();
        self.whole.snapshot(&mut snapshot)?;
        let Work { evaluations, neighbour_visits, .. } = self.work;
        let (rows, cpu_seconds) = (self.rows.to_vec(), self.cpu_seconds);
        Ok(Reached { rows, snapshot, evaluations, neighbour_visits, cpu_seconds })
    }
}

/// Resumes a run with the same choices from a stored state; results are bitwise identical to an uninterrupted run.
///
/// The earlier run may have had fewer times. `look` is not called for times that it has already observed. `goes_on` is asked before
/// each step with the present time; once it returns false, the run ends there, with a last look.
///
/// # Errors
/// As [`run_on`], and those of [`Simulation::restore`].
pub fn run_from<S: Sde<D, M>, O: DensitySimulation<S, D, M>, const D: usize, const M: usize>(
    start: impl FnOnce() -> Result<O, Error>,
    asked: &Requested<D>,
    past: Reached,
    mut look: impl FnMut(ObservedRun<'_, S, D, M>),
    goes_on: &mut (dyn FnMut(f64) -> bool + Send),
) -> Result<DensityRun, Error> {
    let clock = CpuClock::start();
    let mut simulation = start()?;
    let n_particles = simulation.density().n_particles();
    if !past.snapshot.is_empty() {
        simulation.restore(past.snapshot.as_slice())?;
    }
    let mut cpu_seconds = past.cpu_seconds + clock.seconds();
    // The work of the start is already counted in the past.
    let before =
        if past.snapshot.is_empty() { Work::default() } else { simulation.density().work() };
    let work = |simulation: &Simulation<S, D, M>| {
        let Work { steps, evaluations, neighbour_visits } = simulation.work();
        Work {
            steps,
            evaluations: past.evaluations + evaluations - before.evaluations,
            neighbour_visits: past.neighbour_visits + neighbour_visits - before.neighbour_visits,
        }
    };
    let mut rows = past.rows;
    rows.truncate(asked.times.len());
    let mut run = DensityRun { rows, n_particles, work: Work::default(), stopped: None };
    for &t in asked.times.iter().skip(run.rows.len()) {
        let start = CpuClock::start();
        let outcome = advance_over(&mut simulation, &asked.kinks, t, goes_on);
        cpu_seconds += start.seconds();
        let is_halted = outcome.is_ok() && simulation.density().time() < t;
        let row = outcome.and_then(|()| {
            let correction = simulation.moment_correction();
            let observed = || observe(simulation.density(), asked, correction, cpu_seconds);
            (!is_halted).then(observed).transpose()
        });
        match row {
            Ok(row) => {
                run.rows.extend(row);
                let (density, rows) = (simulation.density(), &*run.rows);
                let work = work(density);
                let whole = &simulation;
                look(ObservedRun {
                    simulation: density,
                    rows,
                    is_halted,
                    whole,
                    work,
                    cpu_seconds,
                });
                if is_halted {
                    break;
                }
            }
            Err(error) => {
                run.stopped = Some(error);
                break;
            }
        }
    }
    run.work = work(simulation.density());
    Ok(run)
}

/// Steps to a time, with a step that ends at each kink before it.
fn advance_over<S, O: DensitySimulation<S, D, M>, const D: usize, const M: usize>(
    simulation: &mut O,
    kinks: &[f64],
    end: f64,
    goes_on: &mut (dyn FnMut(f64) -> bool + Send),
) -> Result<(), Error>
where
    S: Sde<D, M>,
{
    for stop in stops_before(kinks, simulation.density().time(), end) {
        simulation.advance_while(stop, goes_on)?;
        if simulation.density().time() < stop {
            return Ok(());
        }
    }
    simulation.advance_while(end, goes_on)
}

fn observe<S: Sde<D, M>, const D: usize, const M: usize>(
    simulation: &Simulation<S, D, M>,
    asked: &Requested<D>,
    correction: Option<Correction<D>>,
    cpu_seconds: f64,
) -> Result<Row, Error> {
    let cells = asked.cells.then(|| simulation.cell_integral()).transpose()?;
    let corrected = |x: &[f64; D]| correction.map_or(*x, |correction| correction.of(x));
    let exceedances = exceedances(simulation, cells.as_ref(), asked, &corrected)?;
    let moments: Vec<f64> = asked.powers.iter().map(|&it| simulation.raw_moment(it)).collect();
    let offset = |(moment, &powers): (&f64, &[u32; D])| {
        moment - simulation.expectation(|x| monomial(powers, &corrected(x)))
    };
    Ok(Row {
        t: simulation.time(),
        offsets: moments.iter().zip(&asked.powers).map(offset).collect(),
        scales: asked.powers.iter().map(|&it| simulation.absolute_moment(it)).collect(),
        violation: correction.map_or(0.0, |correction| correction.relative_change()),
        moments,
        exceedances,
        total_mass: simulation.total_mass(),
        mass_outside: simulation.mass_outside(),
        is_remeshed: simulation.n_remaps() > 0,
        entropy: simulation.entropy()?,
        cell_mass: cells.as_ref().map(CellIntegral::total_mass),
        cpu_seconds,
    })
}

fn exceedances<S: Sde<D, M>, const D: usize, const M: usize>(
    simulation: &Simulation<S, D, M>,
    cells: Option<&CellIntegral<D>>,
    asked: &Requested<D>,
    corrected: &dyn Fn(&[f64; D]) -> [f64; D],
) -> Result<Vec<Exceedances>, Error> {
    let magnitude = |x: &[f64; D]| asked.demand.magnitude(x);
    let beside = asked.thresholds.iter().flat_map(|threshold| BESIDE.map(|part| part * threshold));
    let all: Vec<f64> = asked.thresholds.iter().copied().chain(beside).collect();
    let over_cells = cells.map(|cells| cells.exceedances(magnitude, &all));
    let over_cells = over_cells.transpose()?.unwrap_or_default();
    let (over_cells, beside) =
        over_cells.split_at_checked(asked.thresholds.len()).unwrap_or_default();
    let at = |(k, &threshold): (usize, &f64)| {
        let over_cells = over_cells.get(k);
        let beside = beside.as_chunks::<2>().0.get(k);
        let log_interpolated = simulation.exceedance_log_interpolated(magnitude, threshold)?;
        let moved = |x: &[f64; D]| magnitude(&corrected(x));
        Ok(Exceedances {
            indicator: simulation.exceedance_indicator(magnitude, threshold)?,
            log_interpolated,
            offset: log_interpolated - simulation.exceedance_log_interpolated(moved, threshold)?,
            cell_integrated: over_cells.map(|over| estimate(over.probability())),
            note: over_cells.and_then(|over| note(over.probability())),
            beside: beside.map(|two| two.map(|over| estimate(over.probability()))),
        })
    };
    asked.thresholds.iter().enumerate().map(at).collect()
}

/// `x_1^a_1 .. x_D^a_D`.
pub(crate) fn monomial<const D: usize>(powers: [u32; D], x: &[f64; D]) -> f64 {
    let power = |base: f64, exponent: u32| (0..exponent).fold(1.0, |product, _| product * base);
    x.iter().zip(powers).map(|(&x, a)| power(x, a)).product()
}

/// What a probability rests on, where it is less than particles.
fn note(probability: Probability) -> Option<String> {
    probability.resolved().is_none().then(|| probability.basis())
}

/// The estimate whatever it rests on, for a record that has the note next to it and for comparison with a reference.
#[must_use]
pub const fn estimate(probability: Probability) -> f64 {
    match probability {
        Probability::Resolved(estimate)
        | Probability::Truncated { estimate, .. }
        | Probability::Extrapolated { estimate, .. }
        | Probability::Unresolved { estimate, .. }
        | Probability::Below { estimate, .. } => estimate,
    }
}

/// A system behind a reference.
///
/// With it the solver is compiled once for each dimension and class of noise, not for each system of a scene.
#[derive(Clone, Copy)]
pub struct Erased<'a, N: NoiseClass, const D: usize, const M: usize>(
    pub &'a dyn Sde<D, M, Noise = N>,
);

impl<N: NoiseClass, const D: usize, const M: usize> Sde<D, M> for Erased<'_, N, D, M> {
    type Noise = N;

    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.drift(t, x)
    }

    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; M]; D] {
        self.0.noise(t, x)
    }

    fn diffusion(&self, t: f64, x: &[f64; D]) -> [[f64; D]; D] {
        self.0.diffusion(t, x)
    }

    fn diffusion_divergence(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.diffusion_divergence(t, x)
    }

    fn linear_part(&self) -> Option<[[f64; D]; D]> {
        self.0.linear_part()
    }
}

impl<N: NoiseClass, const D: usize, const M: usize> std::fmt::Debug for Erased<'_, N, D, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Erased<{D}, {M}>")
    }
}
