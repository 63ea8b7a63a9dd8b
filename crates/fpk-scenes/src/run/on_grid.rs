//! A density scene on a conservative grid, with coarser grids for its error.

use fpk_sph::InitialLattice;
use random_vibration::{GridConfig, GridDensity};
use scene_runs::answers::Unknown;
use scene_runs::causes::with_causes;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Run, RunError, SolverError};
use sde_integrators::GaussianMixture;

use super::observed::{Observed, Refinement};
use super::record::{Content, SharedError, WorkRecord, asked_series, at, order, progress_words};
use super::resolution_error::{Orders, StepsOfInterval};
use super::step_runs::kinks_of_steps;
use crate::density::Requested;
use crate::kinks::stops_before;
use crate::scene::{FpkScene, OtherDimension};
use crate::system::System;

/// Results at one time.
struct Row {
    t: f64,
    moments: Vec<f64>,
    /// Second moments of both states.
    squares: [f64; 2],
    exceedances: Vec<f64>,
}

impl Row {
    /// The scale of a moment: that of independent normals, of absolute values.
    fn scale(&self, powers: [u32; 2]) -> f64 {
        let of = |(power, square): (u32, f64)| {
            let factor = ABSOLUTE_MOMENTS.get(power as usize).copied().unwrap_or(f64::INFINITY);
            factor * square.powf(0.5 * f64::from(power))
        };
        powers.into_iter().zip(self.squares).map(of).product()
    }
}

/// `E abs(z)^p` of a standard normal for the powers that a grid takes, `p = 0..=4`: `sqrt(2/pi)` and twice that for the odd ones.
const ABSOLUTE_MOMENTS: [f64; 5] = [1.0, 0.797_884_560_802_865, 1.0, 1.595_769_121_605_73, 3.0];

/// Runs of a scene on grids.
struct GridRuns<'a> {
    scene: &'a FpkScene,
    system: &'a System,
    run: &'a Run<'a>,
    asked: &'a Requested<2>,
    law: GaussianMixture<2>,
    /// Kinks of the noise at which steps end; none where a run has fewer steps than the noise has kinks.
    kinks: Option<Vec<f64>>,
}

impl GridRuns<'_> {
    /// What one grid sees at each time, and its steps.
    fn follow(&self, config: &GridConfig) -> Result<(Vec<Row>, u64), RunError> {
        let pace = self.run.pace("conservative grid");
        let found = self.followed_while(config, &mut |done| pace.goes_on(done));
        RunError::if_ended_early(&pace)?;
        found.map_err(RunError::Solver)
    }

    fn followed_while(
        &self,
        config: &GridConfig,
        goes_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<(Vec<Row>, u64), SolverError> {
        let oscillator = self.system.oscillator().ok_or(OtherDimension { states: 2 })?;
        let mut density = GridDensity::new(oscillator, &self.law, *config)?;
        let (asked, until) = (self.asked, self.scene.times.until);
        let mut rows: Vec<Row> = Vec::with_capacity(asked.times.len());
        for &t in &asked.times {
            let kinks = self.kinks.as_deref().unwrap_or_default();
            for stop in stops_before(kinks, density.time(), t).into_iter().chain([t]) {
                density.advance_while(stop, &mut |now| goes_on(now / until))?;
                if density.time() < stop {
                    return Ok((rows, density.steps()));
                }
            }
            let moments = asked.powers.iter().map(|&powers| density.raw_moment(powers));
            let moments = moments.collect::<Result<Vec<f64>, _>>()?;
            let done = (rows.len() as u64 + 1, asked.times.len() as u64);
            self.run.progress.at(done, || progress_words(self.scene, self.system, t, &moments));
            let exceedances = asked.thresholds.iter().map(|&limit| density.exceedance(limit));
            let squares = [density.raw_moment([2, 0])?, density.raw_moment([0, 2])?];
            rows.push(Row { t, moments, squares, exceedances: exceedances.collect() });
        }
        Ok((rows, density.steps()))
    }

    /// Grids that are coarser in steps, and others in cells, with the reasons of those that fail.
    fn refinements(
        &self,
        config: &GridConfig,
        pairs: &StepsOfInterval,
    ) -> ([Refinement<Row>; 2], Vec<String>) {
        let mut failed = Vec::new();
        let mut other = |config: &GridConfig, what: &str| {
            self.run.progress.stage(&format!("grid {what}, for its error"));
            let rows = self.follow(config).map(|(rows, _)| rows);
            rows.unwrap_or_else(|error| {
                failed.push(format!("{what}: {}", with_causes(&error)));
                Vec::new()
            })
        };
        let every = self.scene.times.every;
        let (ratio, next) = pairs.ratios();
        let coarse = (other(&with_pairs(config, pairs.coarse, every), "coarser in steps"), ratio);
        // One that is too coarse for the scheme is left out.
        let coarsest = pairs.coarsest.zip(next).and_then(|(n, next)| {
            let config = with_pairs(config, n, every);
            let is_admitted = config.steps_per_period >= FEWEST_STEPS_OF_COARSEST;
            is_admitted.then(|| (other(&config, "coarser twice in steps"), next))
        });
        // Steps lose their order across kinks.
        let (of_method, largest) = if self.kinks.is_some() { (2.0, 4.0) } else { (1.0, 1.0) };
        let of_steps = Refinement { coarse, coarsest, orders: Orders { of_method, largest } };
        let (coarse, ratio) = with_cells(config, 1.0 / RATIO);
        let (coarsest, next) = with_cells(&coarse, 1.0 / RATIO);
        let of_cells = if coarsest.cells >= FEWEST_CELLS_OF_COARSEST {
            Refinement {
                coarse: (other(&coarse, "coarser in cells"), ratio),
                coarsest: Some((other(&coarsest, "coarser twice in cells"), next)),
                orders: Orders { of_method: 3.0, largest: 5.0 },
            }
        } else {
            // One grid that is coarser still does not show an error that changes its sign: of 27 cells it was 16 times too small.
            let (finer, ratio) = with_cells(config, RATIO);
            Refinement {
                coarse: (other(&finer, "finer in cells"), ratio),
                coarsest: None,
                orders: Orders { of_method: 2.0, largest: 2.0 },
            }
        };
        ([of_steps, of_cells], failed)
    }
}

/// Runs the grid of the scene, and those that are coarser in steps and in cells.
pub(super) fn solve(
    scene: &FpkScene,
    system: &System,
    run: &Run<'_>,
    config: &GridConfig,
) -> Result<Content, RunError> {
    let (law, asked) = (scene.initial_law::<2>(system)?, scene.requested::<2>(system, false)?);
    run.progress.stage("conservative grid");
    let clock = CpuClock::start();
    let every = scene.times.every;
    let pairs = StepsOfInterval::new(0.5 * every * config.steps_per_period / config.period, RATIO);
    let config = with_pairs(config, pairs.fine, every);
    let kinks = kinks_of_steps(scene, config.steps_per_period * scene.times.until / config.period);
    let runs = GridRuns { scene, system, run, asked: &asked, law, kinks };
    let (fine, steps) = runs.follow(&config)?;
    let work =
        WorkRecord { steps: Some(steps), cpu_seconds: clock.seconds(), ..WorkRecord::default() };
    let (refinements, failed) = runs.refinements(&config, &pairs);
    let values = |pick: &dyn Fn(&Row) -> f64| {
        Observed::of_runs(&fine, &refinements, &|row| (row.t, pick(row)))
    };
    // A normal distribution has its moments and probabilities beyond the grid as beyond a lattice of the same reach.
    let lattice = InitialLattice::Box { reach: config.reach, count: [3; 2] };
    let by_runs: Vec<Vec<Observed>> =
        (0..asked.powers.len()).map(|k| values(&|row| row.moments[k])).collect();
    let scale = |k: usize, t: f64| {
        let row = fine.iter().find(|row| row.t.to_bits() == t.to_bits());
        let value = at(&by_runs[k], t).map_or(0.0, |observed| observed.value.abs());
        row.map_or(0.0, |row| row.scale(asked.powers[k])).max(value)
    };
    let order_and_scale = |k: usize, t: f64| f64::from(order(&asked.powers[k])) * scale(k, t);
    let shared = |t: f64| {
        let of = |(k, values): (usize, &Vec<Observed>)| {
            (at(values, t).and_then(|it| it.error), order_and_scale(k, t))
        };
        SharedError::of(by_runs.iter().enumerate().map(of))
    };
    let exceedance = |k: usize| {
        let beyond = "no mass of the grid is beyond the threshold";
        let outside = lattice.moment_outside(&[1.0; 2], 0);
        let values = values(&|row| row.exceedances[k]).into_iter();
        let complete = |mut observed: Observed| {
            observed.raise_error(shared(observed.t).of_probability(observed.value));
            if observed.value <= outside {
                observed.bounded_by(outside);
            } else {
                observed.may_lack(outside);
            }
            observed.without_zero_error(beyond)
        };
        values.map(complete).collect()
    };
    let moment = |k: usize| {
        let lacking = lattice.moment_lacking(&[1.0; 2], asked.powers[k].iter().sum());
        let mut values = by_runs[k].clone();
        for observed in &mut values {
            observed.raise_error(shared(observed.t).of_moment(order_and_scale(k, observed.t)));
            observed.add_error(Some(lacking * scale(k, observed.t)));
        }
        values
    };
    let quantities = asked_series(scene, system, &moment, &exceedance);
    let unknown = (!failed.is_empty()).then(|| Unknown {
        what: "errors of all quantities".to_owned(),
        reason: format!(
            "they are estimated from runs on other grids, which failed: {}",
            failed.join("; ")
        ),
    });
    Ok(Content { work, unknown: unknown.into_iter().collect(), quantities, ..Content::default() })
}

/// Ratio of the resolutions of the coarser runs. A grid coarser in cells and steps at once lets the two errors cancel: for the damper the
/// difference was 8e-5 for an error of 9e-4.
const RATIO: f64 = std::f64::consts::SQRT_2;
/// Limits of the grid, below which a second coarser run is left out.
const FEWEST_STEPS_OF_COARSEST: f64 = 4.0;
const FEWEST_CELLS_OF_COARSEST: usize = 16;

/// A grid with as many pairs of steps in an interval between observations.
fn with_pairs(grid: &GridConfig, n: u32, every: f64) -> GridConfig {
    GridConfig { steps_per_period: 2.0 * f64::from(n) * grid.period / every, ..*grid }
}

/// A grid with another number of cells, and the ratio of its width of a cell to that of the first.
fn with_cells(grid: &GridConfig, factor: f64) -> (GridConfig, f64) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "about as many")]
    let cells = (grid.cells as f64 * factor).round() as usize;
    (GridConfig { cells, ..*grid }, grid.cells as f64 / cells as f64)
}
