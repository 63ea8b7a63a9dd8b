//! The error of the steps of a density run: runs on the same lattice with other steps.

use fpk_sph::{Combination, Config, Error, Method, StepRule};

use super::resolution_error::{Coarser, Orders, StepsOfInterval, error_of_finest};
use crate::density::DensityRun;
use crate::scene::FpkScene;

/// Runs on one lattice with other steps than those of the fine run.
pub(super) enum StepRuns {
    /// Longer steps, with the ratio to those of the next shorter ones, and the order in them.
    Longer { coarse: (DensityRun, f64), coarsest: Option<(DensityRun, f64)>, order: f64 },
    /// Half the step, where a limit of stability does not let it be longer.
    Halved(DensityRun),
    /// None came so far.
    Failed,
}

impl StepRuns {
    /// The error of the steps of a run with this value.
    pub(super) fn error(
        &self,
        value: f64,
        pick: impl Fn(&DensityRun) -> Option<f64>,
    ) -> Option<f64> {
        match self {
            Self::Failed => None,
            Self::Halved(run) => Some((value - pick(run)?).abs()),
            Self::Longer { coarse, coarsest, order } => {
                let at = |(run, ratio): &(DensityRun, f64)| {
                    Some(Coarser { value: pick(run)?, ratio: *ratio })
                };
                let coarsest = coarsest.as_ref().and_then(at);
                let orders = Orders { of_method: *order, largest: 4.0 };
                Some(error_of_finest(value, at(coarse)?, coarsest, orders))
            }
        }
    }
}

/// The time between observations, as the steps see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    /// In reference periods.
    pub(super) periods: f64,
    /// Whether steps cross kinks of the noise.
    pub(super) has_kinks: bool,
}

impl Interval {
    /// Of a scene, and the kinks of its noise at which steps end.
    pub(super) fn of_scene<const D: usize>(
        scene: &FpkScene,
        config: Option<&Config<D>>,
        period: f64,
    ) -> (Self, Vec<f64>) {
        let steps = match config.map(|config| config.method.combination_in(D).step) {
            Some(StepRule::PeriodFraction { steps_per_period }) => {
                steps_per_period * scene.times.until / period
            }
            _ => 0.0,
        };
        let kinks = kinks_of_steps(scene, steps);
        (
            Self { periods: scene.times.every / period, has_kinks: kinks.is_none() },
            kinks.unwrap_or_default(),
        )
    }
}

/// Kinks of the noise at which the steps of a run end, sorted: all of them, and none where a tabulated window has more rows than the run
/// has steps, which then cross them.
pub(super) fn kinks_of_steps(scene: &FpkScene, steps: f64) -> Option<Vec<f64>> {
    let mut kinks = scene.system.kinks();
    kinks.retain(|&t| t > 0.0 && t < scene.times.until);
    kinks.sort_by(f64::total_cmp);
    (kinks.len() as f64 <= steps).then_some(kinks)
}

/// Runs with steps twice and four times as long as those of a run, or with half of them where a limit of stability gives longer ones
/// about the same length. None by a rule whose steps follow the spacing.
pub(super) fn step_runs<E, const D: usize>(
    (config, base): (&Config<D>, &DensityRun),
    Interval { periods: interval, has_kinks }: Interval,
    solve: impl Fn(&str, &Config<D>) -> Result<Result<DensityRun, Error>, E>,
) -> Result<Option<StepRuns>, E> {
    let StepRule::PeriodFraction { steps_per_period } = config.method.combination_in(D).step else {
        return Ok(None);
    };
    let steps = StepsOfInterval::new(steps_per_period * interval, 2.0);
    let with = |n: u32| with_steps(*config, |_| f64::from(n) / interval);
    let came_as_far = |run: &DensityRun| run.rows.len() >= base.rows.len();
    // The run with the ratio of its steps to those of another, if that shows their error.
    let longer = |run: DensityRun, than: &DensityRun| {
        let ratio = than.work.steps as f64 / run.work.steps as f64;
        (came_as_far(&run) && ratio > LEAST_RATIO).then_some((run, ratio))
    };
    let coarse = solve("longer steps", &with(steps.coarse))?.ok();
    if let Some(coarse) = coarse.and_then(|run| longer(run, base)) {
        let coarsest = match steps.coarsest {
            Some(n) => solve("the longest steps", &with(n))?.ok(),
            None => None,
        };
        let coarsest = coarsest.and_then(|run| longer(run, &coarse.0));
        let order = match (has_kinks, &coarsest) {
            (true, _) => 1.0,
            (false, None) => 2.0,
            (false, Some(_)) => 4.0,
        };
        return Ok(Some(StepRuns::Longer { coarse, coarsest, order }));
    }
    let each = base.work.steps as f64 / base.rows.len() as f64;
    let halved = solve("half the step", &with_steps(*config, |_| 2.0 * each / interval))?.ok();
    Ok(Some(halved.filter(came_as_far).map_or(StepRuns::Failed, StepRuns::Halved)))
}

/// Ratio of the steps of two runs below which their difference does not show the error of the steps.
const LEAST_RATIO: f64 = 1.2;

/// The configuration with a whole number of steps in an interval between observations, two at least, so that a coarser run has fewer.
pub(super) fn with_steps_of_interval<const D: usize>(
    config: Config<D>,
    Interval { periods: interval, .. }: Interval,
) -> Config<D> {
    with_steps(config, |steps_per_period| {
        f64::from(StepsOfInterval::new(steps_per_period * interval, 2.0).fine) / interval
    })
}

/// The configuration with other steps, where the rule is a fraction of the period.
fn with_steps<const D: usize>(config: Config<D>, steps: impl Fn(f64) -> f64) -> Config<D> {
    let combination = config.method.combination_in(D);
    let StepRule::PeriodFraction { steps_per_period } = combination.step else {
        return config;
    };
    let step = StepRule::PeriodFraction { steps_per_period: steps(steps_per_period) };
    Config { method: Method::Custom(Combination { step, ..combination }), ..config }
}
