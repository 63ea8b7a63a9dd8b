//! The linear oscillator, whose answer is exact.

use fpk_sph::{Config, Simulation};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::Problem;
use scenes::fpk::density::{DensityRun, Row, estimate, run_on};

use super::{ExceedanceEstimator, Judge, asked};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/linear-oscillator-flow-map",
    title: "Linear oscillator in an earthquake, flow-map fit: exact answer",
    source: "Canor & Denoël 2013, eq 26 with eta = 0, window of eq 27; Lyapunov equation",
    cost: Profile::Quick,
    run: Together(run),
};

const TIMES: [f64; 10] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];

/// Smallest probability that is claimed.
const FLOOR: f64 = 1e-9;

/// What is known of the density beside moments and tails.
struct Exactness {
    t: f64,
    density_error: f64,
    marginal_error: f64,
    limit_state: (f64, f64),
    entropy: (f64, f64),
}

fn run(context: &Context<'_>) -> CaseResult {
    let problem = Problem::linear_oscillator()?;
    let config = problem.density_config(1.0)?;
    let (run, exactness) = density_run(context, &problem, &config)?;
    let method = run.words("flow-map fit, box of 7 sigma");
    let lines = context.lines("flow-map-fit", method);
    let judge = Judge { problem: &problem, run: &run, lines };
    let mut claims = moments(&judge)?;
    claims.extend(densities(&judge, &exactness)?);
    claims.extend(exceedances(&judge)?);
    claims.push(interpolated_at_start(context, &problem, &config)?);
    Ok(claims)
}

const STEP: &str = "error of Runge-Kutta 4 at 40 steps a period; a Gaussian has no error of space";

fn density_run(
    context: &Context<'_>,
    problem: &Problem,
    config: &Config<2>,
) -> CaseResult<(DensityRun, Vec<Exactness>)> {
    let Oscillator::Linear(system) = problem.system.clone() else {
        return Err("the scene holds another system".into());
    };
    let mut exactness = Vec::new();
    let mut failure = None;
    let run =
        run_on(system, &problem.law, config, &asked(&TIMES, problem, true), |simulation, row| {
            context.progress(&format!("t = {}", row.t));
            match look(problem, simulation, row) {
                Ok(found) => exactness.push(found),
                Err(error) => failure = failure.take().or(Some(error)),
            }
        })?;
    failure.map_or(Ok((run, exactness)), Err)
}

fn look<S: sde_integrators::Sde<2, 1>>(
    problem: &Problem,
    simulation: &Simulation<S, 2, 1>,
    row: &Row,
) -> CaseResult<Exactness> {
    let moment =
        |powers| problem.reference.moment(powers, row.t).map(|r| r.value).ok_or("no exact moment");
    let (qq, qv, vv) = (moment([2, 0])?, moment([1, 1])?, moment([0, 2])?);
    let determinant = qq * vv - qv * qv;
    let exact = |x: &[f64; 2]| {
        let exponent =
            (vv * x[0] * x[0] - 2.0 * qv * x[0] * x[1] + qq * x[1] * x[1]) / (2.0 * determinant);
        (-exponent).exp() / (std::f64::consts::TAU * determinant.sqrt())
    };
    let cells = simulation.cell_integral()?;
    // A limit state that no axis carries: q + v/3 beyond three of its standard deviations.
    let deviation = (qq + 2.0 * qv / 3.0 + vv / 9.0).sqrt();
    let probability = cells.exceedance(|x| x[0] + x[1] / 3.0, 3.0 * deviation)?;
    Ok(Exactness {
        t: row.t,
        density_error: simulation.density_error(exact)?,
        marginal_error: marginal_error(&cells, qq.sqrt())?,
        limit_state: (estimate(probability.probability()), UPPER_TAIL_AT_3),
        entropy: (
            row.entropy,
            0.5 * ((std::f64::consts::TAU * std::f64::consts::E).powi(2) * determinant).ln(),
        ),
    })
}

/// `P(Z > 3)` of a standard normal.
const UPPER_TAIL_AT_3: f64 = 1.349898031630095e-3;

/// L1 distance of the marginal of `q`, in bins of a quarter standard deviation, from the exact one.
fn marginal_error(
    cells: &fpk_sph::observables::CellIntegral<2>,
    deviation: f64,
) -> CaseResult<f64> {
    let edges: Vec<f64> = (-20..=20).map(|k| f64::from(k) * 0.25 * deviation).collect();
    let density = cells.marginal(0, &edges)?;
    // The mean of a normal density over a bin, by Gauss-Legendre with three points: error 1e-9.
    let nodes = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
    let normal = |q: f64| {
        (-0.5 * (q / deviation).powi(2)).exp() / (deviation * std::f64::consts::TAU.sqrt())
    };
    Ok(density
        .iter()
        .zip(edges.windows(2))
        .map(|(found, bin)| {
            let (centre, half) = (0.5 * (bin[0] + bin[1]), 0.5 * (bin[1] - bin[0]));
            let exact: f64 = nodes.iter().map(|(x, w)| w * normal(centre + half * x)).sum();
            (found - exact).abs() * (bin[1] - bin[0])
        })
        .sum())
}

fn moments(judge: &Judge<'_>) -> CaseResult {
    let within = |tolerance| Criterion::Within { tolerance, reason: STEP };
    Ok(vec![
        judge.worst_moment([2, 0], &TIMES, within(3e-5))?,
        judge.worst_moment([0, 2], &TIMES, within(3e-5))?,
        judge.worst_correlation(&TIMES, within(1e-4))?,
    ])
}

/// A value at each time against what it should be: the worst.
fn over_times(
    judge: &Judge<'_>,
    (name, quantity, kind): (&str, &str, ErrorKind),
    exactness: &[Exactness],
    value: impl Fn(&Exactness) -> (f64, f64),
    criterion: Criterion<'_>,
) -> CaseResult<Claim> {
    let family = exactness.iter().map(|found| {
        let (value, expected) = value(found);
        let subject = judge.lines.of(format!("{name}/t{}", found.t), quantity);
        subject.compared(kind, value, expected).judged(criterion)
    });
    judge.worst(name, &TIMES, family.collect())
}

fn densities(judge: &Judge<'_>, exactness: &[Exactness]) -> CaseResult {
    let within = |tolerance, reason| Criterion::Within { tolerance, reason };
    let of = |name, quantity, kind, value: fn(&Exactness) -> (f64, f64), criterion| {
        over_times(judge, (name, quantity, kind), exactness, value, criterion)
    };
    let mut claims = vec![
        of(
            "density-l2",
            "relative L2 error of psi",
            ErrorKind::Absolute,
            |found| (found.density_error, 0.0),
            within(6e-5, "the density follows the moments, whose error is that of Runge-Kutta 4"),
        )?,
        of(
            "marginal-q",
            "L1 error of the marginal of q",
            ErrorKind::Absolute,
            |found| (found.marginal_error, 0.0),
            within(2e-4, "parts of cells, 1/12 of a spacing wide, spread over bins of 0.25 sigma"),
        )?,
        of(
            "limit-state",
            "P(q + v/3 > 3 sigma)",
            ErrorKind::Log10,
            |found| found.limit_state,
            within(2e-3, "midpoint rule over parts of cells and a limit taken as linear in each"),
        )?,
        of(
            "entropy",
            "entropy (nats)",
            ErrorKind::Absolute,
            |found| found.entropy,
            within(2e-5, "half the relative error of the determinant of the covariance"),
        )?,
    ];
    claims.extend(masses(judge)?);
    Ok(claims)
}

/// The sum of the masses and the mass over the cells at the last time.
fn masses(judge: &Judge<'_>) -> CaseResult<[Claim; 2]> {
    let last = judge.row(10.0)?;
    Ok([
        judge
            .lines
            .of("total-mass/t10", "sum of the masses")
            .absolute(last.total_mass, 1.0)
            .within(1e-11)
            .because("a box of 7 sigma leaves out 5e-12; masses never change"),
        judge
            .lines
            .of("cell-mass/t10", "mass over the cells")
            .absolute(last.cell_mass.unwrap_or(f64::NAN), 1.0)
            .within(3e-9)
            .because("midpoint rule over parts of cells, whose errors cancel in a sum over a smooth density"),
    ])
}

fn exceedances(judge: &Judge<'_>) -> CaseResult {
    let reason =
        "parts of cells and the step: 1e-5 of a variance changes log10 P by 8e-5 at 6 sigma";
    let within = Criterion::Within { tolerance: 2e-4, reason };
    let mut claims =
        vec![judge.worst_exceedance(ExceedanceEstimator::Cell, &TIMES, FLOOR, within)?];
    let reason = "counting particles quantises P by whole layers of the lattice: 0.07 at a spacing of 0.3 sigma";
    let staircase = Criterion::Within { tolerance: 0.09, reason };
    for estimator in [ExceedanceEstimator::Indicator, ExceedanceEstimator::LogInterpolated] {
        claims.push(judge.worst_exceedance(estimator, &TIMES, FLOOR, staircase)?);
    }
    Ok(claims)
}

/// The tail between counted particles at the start, where the density is Gaussian and no step has moved the lattice.
fn interpolated_at_start(
    context: &Context<'_>,
    problem: &Problem,
    config: &Config<2>,
) -> CaseResult<Claim> {
    let Oscillator::Linear(system) = problem.system.clone() else {
        return Err("the scene holds another system".into());
    };
    let simulation = Simulation::new(system, &problem.law, config)?;
    let deviation = simulation.expectation(|x| x[0] * x[0]).sqrt();
    let mut errors = Vec::new();
    // Of 2 (1 - Phi(t)), t in standard deviations.
    for (t, exact) in [(1.0, 0.317_310_507_863), (2.0, 0.045_500_263_896), (3.0, 0.002_699_796_063)]
    {
        let found = simulation.exceedance_log_interpolated(|x| x[0].abs(), t * deviation)?;
        errors.push((found / exact - 1.0).abs());
    }
    let worst = errors.iter().fold(0.0, |most: f64, &e| if e.is_nan() { e } else { most.max(e) });
    let quantity = "worst relative error of P(|q| > k sigma), k = 1, 2, 3";
    let method = "flow-map fit, the lattice of the initial distribution";
    let reason = "second order in the spacing h: (k^2 + 1) h^2/12 at k deviations by the trapezoidal rule over columns, 0.075 at three with h = 0.3 sigma";
    let subject = context.subject("flow-map-fit/exceedance-log-interpolated/t0", quantity, method);
    Ok(subject.bounded(worst, 0.09).because(reason))
}
