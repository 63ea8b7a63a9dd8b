//! A run of the density solver, observed at given times.

use cpu_time::ProcessTime;
use fpk_sph::observables::CellIntegral;
use fpk_sph::{Config, Error, Simulation, Work};
use sde_integrators::{GaussianMixture, Sde};

use super::scene::System;

/// What is asked of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Asked {
    /// When.
    pub times: Vec<f64>,
    /// Raw moments `E[q^a v^b]`.
    pub powers: Vec<[u32; 2]>,
    /// Thresholds `T` of `P(|q| > T)`.
    pub thresholds: Vec<f64>,
    /// Whether to integrate over the particles' cells, which needs local fits.
    pub cells: bool,
}

/// The three estimates of one probability of exceedance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exceedances {
    /// Counted particles (eq 25).
    pub indicator: f64,
    /// Log-interpolated distribution.
    pub log_interpolated: f64,
    /// Integrated over deformed cells; `None` where that was not asked.
    pub cell_integrated: Option<f64>,
}

/// What was observed at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The time.
    pub t: f64,
    /// Raw moments, in the order asked.
    pub moments: Vec<f64>,
    /// Probabilities, in the order of the thresholds.
    pub exceedances: Vec<Exceedances>,
    /// `sum mu_i`.
    pub total_mass: f64,
    /// Entropy (nats).
    pub entropy: f64,
    /// Mass of the density over the cells, where it was asked.
    pub cell_mass: Option<f64>,
    /// Cells in which the fit was not trusted, where cells were asked.
    pub distrusted_cells: Option<usize>,
    /// CPU time of the solver up to here (s), observation excluded.
    pub cpu_seconds: f64,
}

/// A run.
#[derive(Debug)]
pub struct DensityRun {
    /// One row per time reached.
    pub rows: Vec<Row>,
    /// Number of particles.
    pub n_particles: usize,
    /// Work done.
    pub work: Work,
    /// Why the run ended early, if it did.
    pub stopped: Option<Error>,
}

impl DensityRun {
    /// The row of a time that was asked.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<&Row> {
        self.rows.iter().find(|row| (row.t - t).abs() < 1e-9)
    }

    /// Particles, steps and cost in words, for the method column.
    #[must_use]
    pub fn words(&self, method: &str) -> String {
        let cpu = self.rows.last().map_or(0.0, |row| row.cpu_seconds);
        format!(
            "{method}: {} particles, {} steps, {cpu:.2} s CPU",
            self.n_particles, self.work.steps
        )
    }
}

/// Runs the density solver on a built-in system.
///
/// A run that ends early is a result: its rows so far, with the reason in [`DensityRun::stopped`].
///
/// # Errors
/// [`Error`] where the run could not start.
pub fn run(
    system: &System,
    law: &GaussianMixture<2>,
    config: &Config<2>,
    asked: &Asked,
) -> Result<DensityRun, Error> {
    match system.clone() {
        System::Linear(system) => run_on(system, law, config, asked, |_, _| ()),
        System::Damper(system) => run_on(system, law, config, asked, |_, _| ()),
    }
}

/// As [`run`], for any system; `look` sees the simulation at every time.
///
/// # Errors
/// [`Error`] where the run could not start.
pub fn run_on<S: Sde<2, 1>>(
    system: S,
    law: &GaussianMixture<2>,
    config: &Config<2>,
    asked: &Asked,
    mut look: impl FnMut(&Simulation<S, 2, 1>, &Row),
) -> Result<DensityRun, Error> {
    let start = ProcessTime::now();
    let mut simulation = Simulation::new(system, law, config)?;
    let mut cpu_seconds = start.elapsed().as_secs_f64();
    let mut run = DensityRun {
        rows: Vec::new(),
        n_particles: simulation.n_particles(),
        work: Work::default(),
        stopped: None,
    };
    for &t in &asked.times {
        let start = ProcessTime::now();
        let outcome = simulation.advance_to(t);
        cpu_seconds += start.elapsed().as_secs_f64();
        let row = outcome.and_then(|()| observe(&simulation, asked, cpu_seconds));
        match row {
            Ok(row) => {
                look(&simulation, &row);
                run.rows.push(row);
            }
            Err(error) => {
                run.stopped = Some(error);
                break;
            }
        }
    }
    run.work = simulation.work();
    Ok(run)
}

fn observe<S: Sde<2, 1>>(
    simulation: &Simulation<S, 2, 1>,
    asked: &Asked,
    cpu_seconds: f64,
) -> Result<Row, Error> {
    let cells = asked.cells.then(|| simulation.cell_integral()).transpose()?;
    let exceedances = asked
        .thresholds
        .iter()
        .map(|&threshold| exceedances(simulation, cells.as_ref(), threshold))
        .collect::<Result<_, _>>()?;
    Ok(Row {
        t: simulation.time(),
        moments: asked.powers.iter().map(|&powers| simulation.raw_moment(powers)).collect(),
        exceedances,
        total_mass: simulation.total_mass(),
        entropy: simulation.entropy()?,
        cell_mass: cells.as_ref().map(CellIntegral::total_mass),
        distrusted_cells: cells.as_ref().map(CellIntegral::n_distrusted),
        cpu_seconds,
    })
}

fn exceedances<S: Sde<2, 1>>(
    simulation: &Simulation<S, 2, 1>,
    cells: Option<&CellIntegral<2>>,
    threshold: f64,
) -> Result<Exceedances, Error> {
    let displacement = |x: &[f64; 2]| x[0].abs();
    Ok(Exceedances {
        indicator: simulation.exceedance_indicator(displacement, threshold)?,
        log_interpolated: simulation.exceedance_log_interpolated(displacement, threshold)?,
        cell_integrated: cells
            .map(|cells| {
                cells.exceedance(displacement, threshold).map(|exceedance| exceedance.probability)
            })
            .transpose()?,
    })
}
