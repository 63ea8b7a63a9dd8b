//! Estimators run with several seeds: root mean square errors and costs.

use result_figures::{Drawing, Measure, Method, Run, RunOutcome, Words, WorkPrecision};
use scenes::clock::CpuClock;
use scenes::machine::Machine;

use crate::charts::cost::{cost_in_seconds, median_and_half_range, run, table};
use reference_problems::context::CaseError;

/// Runs of a method at one size: the label of the size, and a run with a seed, which returns relative errors.
pub(super) struct Size<'a> {
    pub(super) label: String,
    pub(super) run: Box<dyn Fn(u64) -> Result<Vec<f64>, CaseError> + 'a>,
}

/// Seeds of the compared runs.
const FIRST_SEED: u64 = 1000;

/// Root mean square over seeds and responses of the relative errors at each size. A size that fails ends the method.
pub(super) fn method(name: &str, sizes: &[Size<'_>], n_seeds: u64) -> Method {
    let mut runs = Vec::new();
    for size in sizes {
        let run = at_size(size, n_seeds);
        let is_failed = matches!(run.outcome, RunOutcome::Failed { .. });
        runs.push(run);
        if is_failed {
            break;
        }
    }
    Method { name: name.into(), runs }
}

fn at_size(size: &Size<'_>, n_seeds: u64) -> Run {
    let (mut seconds, mut squares, mut n) = (Vec::new(), 0.0, 0);
    for seed in 0..n_seeds {
        let clock = CpuClock::start();
        let errors = match (size.run)(FIRST_SEED + seed) {
            Ok(errors) => errors,
            Err(error) => {
                let outcome = RunOutcome::Failed { reason: error.to_string() };
                let cost = clock.seconds().max(f64::MIN_POSITIVE);
                return run((cost, 0.0), outcome, Some(size.label.clone()));
            }
        };
        seconds.push(clock.seconds());
        squares += errors.iter().map(|error| error * error).sum::<f64>();
        n += errors.len();
    }
    let (cost, spread) = median_and_half_range(seconds);
    let value = (squares / f64::from(u32::try_from(n).unwrap_or(u32::MAX))).sqrt();
    // Of the root mean square of independent errors; those of one seed are related.
    let standard_error = Some(value / (2.0 * n_seeds as f64).sqrt());
    let outcome = RunOutcome::Error { value, standard_error };
    run((cost, spread), outcome, Some(size.label.clone()))
}

/// The chart of an estimate.
pub(super) fn drawing(
    name: &str,
    mut words: Words,
    series: Vec<Method>,
    (truth_error, n_seeds): (f64, u64),
) -> Result<Drawing, CaseError> {
    words.x_label = "CPU time on one thread (s)".into();
    words.caption.push(format!(
        "Each point: root mean square error of {n_seeds} independent runs, the bar its standard error; across: their median CPU time, the bar half its range."
    ));
    words.caption.push(Machine::read().caption());
    let rows = table(&series);
    let reading = cost_in_seconds(Measure::Relative, truth_error);
    let chart = WorkPrecision { words, reading, series };
    Ok(Drawing::work_precision(name, &chart)?.with_rows(&rows))
}
