//! Error against CPU time for both oscillators, and the exceedance probability over time.

use std::time::Duration;

use fpk_sph::{Combination, Config, InitialLattice, Method as FpkMethod, StepRule};
use result_figures::{
    Drawing, Line, Measure, Method, Reading, Reference, ReferencePoint, ReferencePoints, Run,
    RunOutcome, Scale, TimeSeries, Words, WorkPrecision,
};
use scenes::clock::CpuClock;
use scenes::fpk::density::{Demand, Requested};
use scenes::fpk::monte_carlo::Sampling;
use scenes::machine::Machine;

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::fpk::methods::papers_config;
use reference_problems::fpk::problem::Problem;

pub(crate) const CHART: ChartKind = ChartKind {
    name: "fpk",
    title: "density by particles and Monte Carlo on two oscillators: error against CPU time, exceedance over time",
    draw,
};

/// Time of the error.
const TIME: f64 = 6.0;
/// Threshold of the probability.
const THRESHOLD: f64 = 1.0;

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    // One thread, so CPU time is that of one core.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let mut drawings = Vec::new();
        for (problem, name) in [
            (Problem::linear_oscillator()?, "fpk-linear"),
            (Problem::viscous_damper()?, "fpk-damper"),
        ] {
            drawings.extend(work_precision(context, &problem, name, context.profile)?);
            drawings.push(exceedance(context, &problem, name)?);
        }
        Ok(drawings)
    })
}

/// One run of a method: its cost, and the two quantities.
struct Point {
    label: String,
    cost: f64,
    spread: f64,
    outcome: Result<Values, String>,
}

/// `E[q^2]` and `P(|q| > 1)` with their standard errors.
struct Values {
    second_moment: (f64, Option<f64>),
    probability: (f64, Option<f64>),
}

/// A method and its points.
struct Ladder {
    name: String,
    points: Vec<Point>,
}

/// Charts of error against CPU time: of `E[q^2]`, and of `P(|q| > 1)`.
///
/// # Errors
/// Errors of the runs and of the charts, and a missing reference.
fn work_precision(
    context: &Context<'_>,
    problem: &Problem,
    name: &str,
    profile: Profile,
) -> Result<Vec<Drawing>, CaseError> {
    let ladders = ladders(context, problem, name, profile)?;
    let moment = problem.reference.moment([2, 0], TIME).ok_or("no reference moment")?;
    let tail = problem.reference.exceedance(THRESHOLD, TIME).ok_or("no reference probability")?;
    let words = |title: &str, y_label: &str, reference: Reference| Words {
        title: title.into(),
        subtitle: problem.scene.title.clone(),
        x_label: "CPU time on one thread (s)".into(),
        y_label: y_label.into(),
        caption: vec![
            format!(
                "Reference {:.6e} +- {:.0e}. A Monte Carlo point is one ensemble: its bar is one standard error.",
                reference.value,
                reference.error.unwrap_or(0.0)
            ),
            "Across: median CPU time of three runs, the bar half their range (one run beyond 3 s)."
                .into(),
            Machine::read().caption(),
        ],
    };
    let moments = WorkPrecision {
        words: words("Second moment E[q^2] at t = 6 s", "relative error of E[q^2]", moment),
        reading: cost_in_seconds(
            Measure::Relative,
            moment.error.unwrap_or(0.0) / moment.value.abs(),
        ),
        series: series(&ladders, |values| relative_error(values.second_moment, moment.value)),
    };
    let title = format!("Probability P(|q| > 1) at t = 6 s: {:.1e}", tail.value);
    let tails = WorkPrecision {
        words: words(&title, "error of log10 P", tail),
        reading: cost_in_seconds(
            Measure::Log10,
            tail.error.unwrap_or(0.0) / (tail.value * std::f64::consts::LN_10),
        ),
        series: series(&ladders, |values| log10_error(values.probability, tail.value)),
    };
    Ok(vec![
        Drawing::work_precision(&format!("{name}-second-moment"), &moments)?,
        Drawing::work_precision(&format!("{name}-tail"), &tails)?,
    ])
}

/// CPU seconds across.
pub(super) fn cost_in_seconds(errors: Measure, reference_error: f64) -> Reading {
    Reading::Cost { unit: "s".into(), errors, reference_error }
}

/// Magnitude of an error with its standard error, or why it is unknown.
type Sized = Result<(f64, Option<f64>), String>;

fn relative_error((value, standard_error): (f64, Option<f64>), reference: f64) -> Sized {
    nonzero((value / reference - 1.0).abs(), standard_error.map(|error| error / reference))
}

fn log10_error((value, standard_error): (f64, Option<f64>), reference: f64) -> Sized {
    if value <= 0.0 {
        return Err("no mass beyond the threshold".into());
    }
    let error = standard_error.map(|error| error / (value * std::f64::consts::LN_10));
    nonzero((value / reference).log10().abs(), error)
}

/// Rejects an error of zero, which a logarithmic axis cannot show.
fn nonzero(error: f64, standard_error: Option<f64>) -> Sized {
    if error > 0.0 { Ok((error, standard_error)) } else { Err("no error to the last digit".into()) }
}

fn series(ladders: &[Ladder], error: impl Fn(&Values) -> Sized) -> Vec<Method> {
    let run = |point: &Point| Run {
        cost: point.cost,
        cost_error: (point.spread > 0.0).then_some(point.spread),
        outcome: match point.outcome.as_ref().map_err(Clone::clone).and_then(&error) {
            Ok((value, standard_error)) => RunOutcome::Error { value, standard_error },
            Err(reason) => RunOutcome::Failed { reason },
        },
        label: Some(point.label.clone()),
    };
    ladders
        .iter()
        .map(|ladder| Method {
            name: ladder.name.clone(),
            runs: ladder.points.iter().map(run).collect(),
        })
        .collect()
}

fn ladders(
    context: &Context<'_>,
    problem: &Problem,
    name: &str,
    profile: Profile,
) -> Result<Vec<Ladder>, CaseError> {
    let quick = profile == Profile::Quick;
    let first = |n: usize, all: usize| if quick { n } else { all };
    let period = problem.system.period();
    let paper = papers_config(period);
    let mut ladders = Vec::new();

    let counts = [21_usize, 27, 35, 45, 61, 81];
    let progress = format!("{name}: flow-map fit");
    ladders.push(density(context, problem, &progress, "flow-map fit (particles)", true, |k| {
        let n = *counts.get(k).filter(|_| k < first(4, 6))?;
        let (method, lattice) = (FpkMethod::FlowMapFit, InitialLattice::box_of(n));
        Some((group_thousands(n * n), Config { method, lattice, ..paper }))
    })?);
    ladders.extend(papers_ladders(context, problem, name, quick)?);
    ladders.extend(sampled_ladders(context, problem, name, quick)?);
    Ok(ladders)
}

/// Ladders of the paper's method over lattices, and over Courant numbers.
fn papers_ladders(
    context: &Context<'_>,
    problem: &Problem,
    name: &str,
    quick: bool,
) -> Result<Vec<Ladder>, CaseError> {
    let first = |n: usize, all: usize| if quick { n } else { all };
    let paper = papers_config(problem.system.period());
    let mut ladders = Vec::new();
    let grids = [[25_usize, 17], [36, 24], [50, 33], [71, 47]];
    let particles = "Canor & Denoël 2013, C = 0.8 (particles)";
    ladders.push(density(
        context,
        problem,
        &format!("{name}: the paper's method"),
        particles,
        false,
        |k| {
            let count = *grids.get(k).filter(|_| k < first(3, 4))?;
            let lattice = InitialLattice::Rectangle { half_width: [0.6, 0.4], count };
            Some((group_thousands(count[0] * count[1]), Config { lattice, ..paper }))
        },
    )?);
    let courant = "Canor & Denoël 2013, 1,650 particles (C)";
    ladders.push(density(
        context,
        problem,
        &format!("{name}: its Courant number"),
        courant,
        false,
        |k| {
            let number = *[0.8, 0.4, 0.2].get(k).filter(|_| k < first(2, 3))?;
            let step = StepRule::Courant { number };
            let combination = Combination { step, ..FpkMethod::CanorDenoel2013.combination() };
            Some((
                format!("C {number}"),
                Config { method: FpkMethod::Custom(combination), ..paper },
            ))
        },
    )?);
    Ok(ladders)
}

fn sampled_ladders(
    context: &Context<'_>,
    problem: &Problem,
    name: &str,
    quick: bool,
) -> Result<Vec<Ladder>, CaseError> {
    let first = |n: usize, all: usize| if quick { n } else { all };
    let mut ladders = Vec::new();
    for (by, steps, most, name_of) in [
        (By::Strang, 150_u32, first(3, 5), "Monte Carlo, Strang, 150 steps (paths)"),
        (By::Euler, 1 << 12, first(2, 4), "Monte Carlo, Euler, 4,096 steps (paths)"),
        (
            By::Euler,
            1 << 16,
            first(1, 2),
            "Monte Carlo, Euler, 65,536 steps as in the paper (paths)",
        ),
    ] {
        context.progress(&format!("{name}: {name_of}"));
        ladders
            .push(Ladder { name: name_of.into(), points: monte_carlo(problem, by, steps, most)? });
    }
    Ok(ladders)
}

/// Runs the density solver until there is no further configuration.
fn density(
    context: &Context<'_>,
    problem: &Problem,
    progress: &str,
    name: &str,
    cells: bool,
    next: impl Fn(usize) -> Option<(String, Config<2>)>,
) -> Result<Ladder, CaseError> {
    let asked = Requested {
        times: vec![TIME],
        powers: vec![[2, 0]],
        demand: Demand::displacement(),
        thresholds: vec![THRESHOLD],
        cells,
    };
    let mut points = Vec::new();
    while let Some((label, config)) = next(points.len()) {
        context.progress(&format!("{progress}, {label}"));
        let (outcome, cost, spread) =
            timed(LONG, || problem.density(&config, &asked).map_err(CaseError::from))?;
        let outcome = match (outcome.at(TIME), &outcome.stopped) {
            (Some(row), _) => {
                let exceedance = &row.exceedances[0];
                let probability = exceedance.cell_integrated.unwrap_or(exceedance.indicator);
                Ok(Values {
                    second_moment: (row.moments[0], None),
                    probability: (probability, None),
                })
            }
            (None, Some(error)) => Err(error.to_string()),
            (None, None) => Err("no result at the time asked".into()),
        };
        points.push(Point { label, cost, spread, outcome });
    }
    Ok(Ladder { name: name.into(), points })
}

/// Integrator of the paths.
#[derive(Clone, Copy)]
enum By {
    Strang,
    /// As in the paper.
    Euler,
}

/// Ensembles of 100, 1,000, .. paths.
fn monte_carlo(
    problem: &Problem,
    by: By,
    steps: u32,
    most: usize,
) -> Result<Vec<Point>, CaseError> {
    let asked = Requested {
        times: vec![TIME],
        powers: vec![[2, 0]],
        demand: Demand::displacement(),
        thresholds: vec![THRESHOLD],
        cells: false,
    };
    [100_u64, 1_000, 10_000, 100_000, 1_000_000][..most]
        .iter()
        .map(|&paths| {
            let sampling = Sampling { paths, step: TIME / f64::from(steps), seed: paths };
            let (run, cost, spread) = timed(LONG, || {
                Ok(match by {
                    By::Strang => problem.sampled(&sampling, &asked)?,
                    By::Euler => problem.sampled_by_euler(&sampling, &asked)?,
                })
            })?;
            let row = run.at(TIME).ok_or("no row")?;
            let of =
                |estimate: &sde_integrators::Estimate| (estimate.value, estimate.standard_error());
            let values =
                Values { second_moment: of(&row.moments[0]), probability: of(&row.exceedances[0]) };
            Ok(Point { label: group_thousands_u64(paths), cost, spread, outcome: Ok(values) })
        })
        .collect()
}

/// CPU time above which a run is not repeated.
pub(super) const LONG: Duration = Duration::from_secs(3);

/// The result with its median CPU time and half the range; three runs if one is short.
pub(super) fn timed<T>(
    long: Duration,
    mut work: impl FnMut() -> Result<T, CaseError>,
) -> Result<(T, f64, f64), CaseError> {
    let mut measure = || -> Result<(T, Duration), CaseError> {
        let start = CpuClock::start();
        let result = work()?;
        Ok((result, Duration::from_secs_f64(start.seconds())))
    };
    let (result, first) = measure()?;
    let mut costs = vec![first.as_secs_f64()];
    if first < long {
        for _ in 0..2 {
            costs.push(measure()?.1.as_secs_f64());
        }
    }
    costs.sort_by(f64::total_cmp);
    let spread = 0.5 * (costs[costs.len() - 1] - costs[0]);
    Ok((result, costs[costs.len() / 2], spread))
}

/// Exceedance probability of every threshold over time, with references as points.
///
/// # Errors
/// Errors of the run and of the chart, and a scene without a density method.
fn exceedance(context: &Context<'_>, problem: &Problem, name: &str) -> Result<Drawing, CaseError> {
    context.progress(&format!("{name}: exceedance over time"));
    let config = problem.density_config(1.0)?;
    let thresholds = &problem.scene.thresholds;
    let asked = Requested {
        times: problem.scene.times.list(),
        powers: vec![],
        demand: Demand::displacement(),
        thresholds: thresholds.clone(),
        cells: true,
    };
    let run = problem.density(&config, &asked)?;
    let lines = thresholds
        .iter()
        .enumerate()
        .map(|(k, threshold)| Line {
            name: format!("T = {threshold}"),
            points: run
                .rows
                .iter()
                .map(|row| (row.t, row.exceedances[k].cell_integrated.filter(|&p| p >= SHOWN)))
                .collect(),
        })
        .collect();
    let reference = |threshold: f64| {
        problem.reference.times().iter().filter_map(move |&x| {
            let reference = problem.reference.exceedance(threshold, x)?;
            (reference.value >= SHOWN).then_some(ReferencePoint {
                x,
                y: reference.value,
                error: reference.error,
            })
        })
    };
    let chart = TimeSeries {
        words: Words {
            title: "Probability of exceedance P(|q| > T), one deterministic run".into(),
            subtitle: problem.scene.title.clone(),
            x_label: "time t (s)".into(),
            y_label: "P(|q| > T)".into(),
            caption: vec![
                format!(
                    "{}; values below {SHOWN:e} are left out.",
                    run.words("Lines: flow-map fit, cell estimator")
                ),
                Machine::read().caption(),
            ],
        },
        scale: Scale::Log,
        lines,
        bands: Vec::new(),
        references: vec![ReferencePoints {
            name: "reference".into(),
            points: thresholds.iter().flat_map(|&threshold| reference(threshold)).collect(),
        }],
    };
    Ok(Drawing::time_series(&format!("{name}-exceedance"), &chart)?)
}

/// Smallest probability on the chart: one decade below the claims.
const SHOWN: f64 = 1e-10;

fn group_thousands(n: usize) -> String {
    group_thousands_u64(n as u64)
}

/// Formats 12345 as `12,345`.
pub(super) fn group_thousands_u64(n: u64) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped() {
        let grouped = [7, 123, 1_000, 1_234_567].map(group_thousands_u64);
        assert_eq!(grouped, ["7", "123", "1,000", "1,234,567"]);
    }
}
