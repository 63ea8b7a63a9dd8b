//! A run of the density solver, observed at given times.

use fpk_sph::{ConditionedSimulation, Config, Correction, Error, Simulation, Work};
use scene_runs::clock::CpuClock;
use sde_integrators::{Additive, GaussianMixture, NoiseClass, Sde};
use serde::{Deserialize, Serialize};

pub use self::requested::{Demand, Requested};
pub use self::row::{Exceedances, Row, estimate};
pub(crate) use self::row::{is_beside, monomial, thresholds_beside};
use crate::kinks::stops_before;

mod requested;
mod row;

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
            let observed = || row::observe(simulation.density(), asked, correction, cpu_seconds);
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
