//! What a multilevel estimate reports of its grids.

use result_figures::number::{percent, tidy};
use serde::Serialize;
use uq_estimators::{LevelReport, MultilevelResult, Statistic, Target, TargetResult, Tolerance};

use super::grid_level::{Grids, Level};

/// Grids of a multilevel estimate and their work.
#[derive(Debug, Clone, Serialize)]
pub(in crate::run) struct MultilevelRecord {
    /// The coarsest first; the last is that of the scene.
    grids: Vec<GridRecord>,
    /// Work of all samples, those of dropped grids included (particle updates: particles times steps).
    work: f64,
    /// Work of plain Monte Carlo on the grid of the scene for the same tolerance, by the variance of the samples there.
    single_grid_work: f64,
    /// Whether all decisive moments meet the tolerance.
    is_reached: bool,
}

/// A grid.
#[derive(Debug, Clone, Serialize)]
struct GridRecord {
    cell: f64,
    particles: usize,
    steps: usize,
    samples: u64,
    /// Work of a sample, that of the coarser grid included (particle updates).
    work_of_sample: f64,
    /// Whether the estimate uses it; its pilot has been computed even if not.
    is_used: bool,
    /// Variance of the difference to the next coarser grid over that of the grid itself: the largest of the decisive moments.
    #[serde(skip_serializing_if = "Option::is_none")]
    variance_of_difference: Option<f64>,
}

impl MultilevelRecord {
    pub(in crate::run) fn new(
        grids: &Grids<'_>,
        targets: &[Target],
        found: &MultilevelResult,
    ) -> Self {
        let is_asked = |target: &Target| target.tolerance != Tolerance::Open;
        let ratio = |level: &LevelReport| {
            let of = |(target, (difference, own)): (&Target, (&f64, &f64))| {
                (is_asked(target) && *own > 0.0).then(|| difference / own)
            };
            let pairs = level.difference_variances.iter().zip(&level.variances);
            targets.iter().zip(pairs).filter_map(of).reduce(f64::max)
        };
        let record = |(k, (grid, level)): (usize, (&Level<'_>, &LevelReport))| GridRecord {
            cell: grid.cell,
            particles: grid.n_particles,
            steps: grid.n_steps,
            samples: level.n_samples,
            work_of_sample: level.cost,
            is_used: level.is_used,
            variance_of_difference: ratio(level).filter(|_| k > 0),
        };
        let mut reached = targets.iter().zip(&found.targets);
        Self {
            grids: grids.levels.iter().zip(&found.levels).enumerate().map(record).collect(),
            work: found.cost,
            single_grid_work: found.single_level_cost,
            is_reached: reached.all(|(target, found)| !is_asked(target) || found.is_reached),
        }
    }
}

/// What a reader must know of an estimate.
pub(in crate::run) fn notes(
    grids: &Grids<'_>,
    targets: &[Target],
    found: &MultilevelResult,
    record: &MultilevelRecord,
) -> Vec<String> {
    let mut notes = vec![
        "standard errors are those of the samples: against the grid of the scene there is no bias, the error of that grid is not in them"
            .to_owned(),
    ];
    let above = record.grids.get(found.coarsest).and_then(|grid| grid.variance_of_difference);
    let reason = above.map_or_else(String::new, |ratio| {
        format!(
            ": the difference between the grids of cell {} and {} has {} of the variance",
            tidy(grids.levels[found.coarsest].cell),
            tidy(grids.levels[found.coarsest.saturating_sub(1)].cell),
            percent(ratio)
        )
    });
    if !found.pays() {
        notes.push(format!(
            "multilevel does not pay, all coarser grids are dropped{reason}; the result is that of plain Monte Carlo"
        ));
    } else if found.coarsest > 0 {
        let dropped: Vec<String> =
            grids.levels[..found.coarsest].iter().map(|level| tidy(level.cell)).collect();
        notes.push(format!(
            "grids of cell {} do not pay and are dropped{reason}",
            dropped.join(", ")
        ));
    }
    let is_negative = |(target, found): &(&Target, &TargetResult)| {
        target.statistic == Statistic::Variance && found.estimate.value < 0.0
    };
    let n_negative = targets.iter().zip(&found.targets).filter(is_negative).count();
    if n_negative > 0 {
        notes.push(format!(
            "{n_negative} variances are below zero, as sums of differences may be: their deviations are given as 0; take a smaller tolerance"
        ));
    }
    notes
}
