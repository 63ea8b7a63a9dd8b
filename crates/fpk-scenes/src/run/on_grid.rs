//! A density scene on a conservative grid, with two coarser grids for its error.

use random_vibration::{GridConfig, GridDensity, GridError};
use scene_runs::answers::Unknown;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Run, RunError};

use super::observed::Observed;
use super::record::{Content, WorkRecord, asked_series, progress_words};
use crate::scene::{FpkScene, OtherDimension};
use crate::system::System;

/// Results at one time.
struct Row {
    t: f64,
    moments: Vec<f64>,
    exceedances: Vec<f64>,
}

/// Runs the grid of the scene, and two that are coarser by a factor of sqrt(2).
pub(super) fn solve(
    scene: &FpkScene,
    system: &System,
    run: &Run<'_>,
    config: &GridConfig,
) -> Result<Content, RunError> {
    let oscillator = system.oscillator().ok_or(OtherDimension { states: 2 });
    let oscillator = oscillator.map_err(RunError::solver)?;
    let (law, asked) = (scene.initial_law::<2>(system)?, scene.requested::<2>(system, false)?);
    let follow = |config: &GridConfig| -> Result<(Vec<Row>, u64), GridError> {
        let mut density = GridDensity::new(oscillator, &law, *config)?;
        let mut rows: Vec<Row> = Vec::with_capacity(asked.times.len());
        for &t in &asked.times {
            density.advance_to(t)?;
            let moments = asked.powers.iter().map(|&powers| density.raw_moment(powers));
            let moments = moments.collect::<Result<Vec<f64>, _>>()?;
            let done = (rows.len() as u64 + 1, asked.times.len() as u64);
            run.progress.at(done, || progress_words(scene, system, t, &moments));
            let exceedances = asked.thresholds.iter().map(|&limit| density.exceedance(limit));
            rows.push(Row { t, moments, exceedances: exceedances.collect() });
        }
        Ok((rows, density.steps()))
    };
    run.progress.stage("conservative grid");
    let clock = CpuClock::start();
    let (fine, steps) = follow(config).map_err(RunError::solver)?;
    let work =
        WorkRecord { steps: Some(steps), cpu_seconds: clock.seconds(), ..WorkRecord::default() };
    let (mut coarser_runs, mut failed) = (Vec::new(), Vec::new());
    for (config, divisor, what) in coarser(config) {
        run.progress.stage(&format!("grid coarser {what}, for its error"));
        match follow(&config) {
            Ok((rows, _)) => coarser_runs.push((rows, divisor)),
            Err(error) => {
                failed.push(format!("coarser {what}: {error}"));
                coarser_runs.push((Vec::new(), divisor));
            }
        }
    }
    let values = |pick: &dyn Fn(&Row) -> f64| {
        Observed::of_runs(&fine, &coarser_runs, &|row| (row.t, pick(row)))
    };
    let exceedance = |k: usize| {
        let beyond = "no mass of the grid is beyond the threshold";
        let values = values(&|row| row.exceedances[k]).into_iter();
        values.map(|observed| observed.without_zero_error(beyond)).collect()
    };
    let quantities = asked_series(scene, system, &|k| values(&|row| row.moments[k]), &exceedance);
    let unknown = (!failed.is_empty()).then(|| Unknown {
        what: "errors of all quantities".to_owned(),
        reason: format!(
            "they are estimated from coarser runs, which failed: {}",
            failed.join("; ")
        ),
    });
    Ok(Content { work, unknown: unknown.into_iter().collect(), quantities, ..Content::default() })
}

/// A grid with fewer cells and one with fewer steps, and the divisors of their differences.
///
/// The divisors follow from Richardson's estimate at order 2 of the splitting in time and order 3 of the remapping, as
/// observed for the damper. A grid coarser in both at once lets the two errors cancel: for the damper the difference
/// was 8e-5 for an error of 9e-4.
fn coarser(config: &GridConfig) -> [(GridConfig, f64, &'static str); 2] {
    let part = config.cells as f64 * std::f64::consts::FRAC_1_SQRT_2;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "fewer than cells")]
    let cells = part.round() as usize;
    let ratio = config.cells as f64 / cells as f64;
    let steps_per_period = config.steps_per_period / ratio;
    [
        (GridConfig { cells, ..*config }, ratio.powi(3) - 1.0, "in cells"),
        (GridConfig { steps_per_period, ..*config }, ratio.powi(2) - 1.0, "in steps"),
    ]
}
