//! Densities that are known: a double well, and processes with multiplicative noise.

use fpk_sph::{Error, InitialLattice, Simulation};
use reference_problems::fpk::reference::BistableReference;
use reference_problems::order;
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::{
    Bistable, BistableParameters, CoxIngersollRoss, CoxIngersollRossParameters,
    GeometricBrownianMotion,
};

use super::{flow_map_fit, worst};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/known-densities",
    title: "Double well, Cox-Ingersoll-Ross, geometric Brownian motion: L1 error of the density",
    source: "finite volumes with extrapolation; Cox, Ingersoll and Ross 1985, eq 18; lognormal law",
    cost: Profile::Quick,
    run: Together(run),
};

/// Standard deviation of the start where it is not given by a reference.
const START_DEVIATION: f64 = 0.05;
/// Where both processes with multiplicative noise start.
const START: f64 = 1.0;
/// The time in which the noise doubles the variance of the start, `sigma^2 / 2D`: 0.028 for the processes with
/// multiplicative noise, 0.02 for the double well. What the fit does not see must be taken out as fast as it arises.
const DOUBLING_TIME: f64 = 0.03;

fn run(context: &Context<'_>) -> CaseResult {
    let (cir, gbm) = (cir()?, GeometricBrownianMotion::new(0.1, 0.3)?);
    let start = GaussianMixture::independent([START], [START_DEVIATION])?;
    let times = [0.25, 0.5, 1.0];
    let mut claims = Vec::new();
    let (name, range) = ("cox-ingersoll-ross", (0.01, 4.0));
    let asks = Asks { name, law: &start, range, times: &times, tolerances: &[4e-7; 3] };
    claims.extend(density_on_a_line(context, cir, &asks, |t, x| cir_density(&cir, t, x))?);
    let (name, range) = ("geometric-brownian-motion", (0.01, 8.0));
    let asks = Asks { name, range, tolerances: &[2e-6; 3], ..asks };
    claims.extend(density_on_a_line(context, gbm, &asks, |t, x| gbm_density(&gbm, t, x))?);
    claims.extend(bistable(context)?);
    Ok(claims)
}

fn cir() -> CaseResult<CoxIngersollRoss> {
    let parameters = CoxIngersollRossParameters { rate: 1.0, mean: 1.0, volatility: 0.3 };
    Ok(CoxIngersollRoss::new(parameters)?)
}

fn cir_density(cir: &CoxIngersollRoss, t: f64, x: f64) -> f64 {
    from_normal(|start| cir.transition_density(start, t, x).unwrap_or(f64::NAN))
}

fn gbm_density(gbm: &GeometricBrownianMotion, t: f64, x: f64) -> f64 {
    from_normal(|start| gbm.transition_density(start, t, x).unwrap_or(f64::NAN))
}

/// The mean of a transition density over the normal start: the trapezoidal rule, whose error is that of the ends at 7
/// standard deviations.
fn from_normal(transition: impl Fn(f64) -> f64) -> f64 {
    let (step, mut sum, mut total) = (0.25, 0.0, 0.0);
    for k in -28..=28 {
        let z = f64::from(k) * step;
        let weight = (-0.5 * z * z).exp();
        total += weight;
        sum += weight * transition(START + START_DEVIATION * z);
    }
    sum / total
}

/// What is asked on a line.
#[derive(Clone, Copy)]
struct Asks<'a> {
    name: &'a str,
    law: &'a GaussianMixture<1>,
    /// Where the density is integrated: all but 1e-8 of it.
    range: (f64, f64),
    times: &'a [f64],
    /// Of the L1 error at each time.
    tolerances: &'a [f64],
}

/// Particles of the run that is claimed.
const COUNT: usize = 200;
/// Particles of the runs that show the order.
const COUNTS: [usize; 4] = [36, 50, 71, 100];
/// When they show it.
const ORDER_TIME: f64 = 0.5;
const REACH: f64 = 5.0;

/// L1 errors at the times reached, and why no further.
struct Errors {
    at: Vec<f64>,
    steps: u64,
    stopped: Option<Error>,
}

fn errors_on_a_line<S: Sde<1, M>, const M: usize>(
    system: S,
    asks: &Asks<'_>,
    count: usize,
    exact: impl Fn(f64, f64) -> f64,
) -> CaseResult<Errors> {
    let config = flow_map_fit(InitialLattice::Box { reach: REACH, count: [count] }, DOUBLING_TIME);
    let mut simulation = Simulation::new(system, asks.law, &config)?;
    let mut at = Vec::new();
    let stopped = simulation
        .run(asks.times, |now| {
            let field = now.density_field()?;
            let t = now.time();
            at.push(l1_on_a_line(asks.range, |x| field.density_at(&[x]), |x| exact(t, x)));
            Ok::<_, Error>(())
        })
        .err();
    Ok(Errors { at, steps: simulation.work().steps, stopped })
}

/// The integral of `|a - b|` by the midpoint rule on 2,000 places.
fn l1_on_a_line((from, to): (f64, f64), a: impl Fn(f64) -> f64, b: impl Fn(f64) -> f64) -> f64 {
    let width = (to - from) / 2000.0;
    let at = |i: i32| from + (f64::from(i) + 0.5) * width;
    (0..2000).map(|i| (a(at(i)) - b(at(i))).abs() * width).sum()
}

fn density_on_a_line<S: Sde<1, M> + Copy, const M: usize>(
    context: &Context<'_>,
    system: S,
    asks: &Asks<'_>,
    exact: impl Fn(f64, f64) -> f64,
) -> CaseResult {
    context.progress(asks.name);
    let errors = errors_on_a_line(system, asks, COUNT, &exact)?;
    if let Some(error) = errors.stopped {
        return Err(error.into());
    }
    let method = format!("flow-map fit: {COUNT} particles, {} steps", errors.steps);
    let lines = context.lines(asks.name, method);
    let mut family = Vec::new();
    for ((t, &error), &tolerance) in asks.times.iter().zip(&errors.at).zip(asks.tolerances) {
        let reason = "truncation of the cubic fit over 200 places in 10 sigma";
        let name = format!("density-l1/t{t}");
        family.push(lines.of(&name, "L1 error of psi").bounded(error, tolerance).because(reason));
    }
    let mut claims = Vec::new();
    // One tolerance for all times, or one for each.
    if asks.tolerances.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits()) {
        let (name, over) =
            (format!("{}/density-l1/worst", asks.name), format!("t = {:?}", asks.times));
        claims.push(worst(context, (&name, &over), family)?);
    } else {
        claims.extend(family);
    }
    let mut levels = Vec::new();
    for count in COUNTS {
        let asks = Asks { times: &[ORDER_TIME], ..*asks };
        let errors = errors_on_a_line(system, &asks, count, &exact)?;
        let error = *errors.at.first().ok_or("the time of the order was not reached")?;
        levels.push((2.0 * REACH / (count as f64 - 1.0), error));
    }
    let order = order::fit(&levels)?;
    let method = format!("flow-map fit: 36 to 100 particles, L1 at t = {ORDER_TIME}");
    let reason = "the gradient of a cubic has order 4 inside and less at the rim; what lies beyond 5 sigma, 6e-7, does not \
                  fall with the spacing";
    let subject = context.subject(format!("{}/order", asks.name), "order in the spacing", &method);
    claims.push(subject.measured(order, (2.5, 4.5)).because(reason));
    Ok(claims)
}

/// The density of a table between its places: the cubic through the four nearest, error 1e-6 here.
fn interpolated(x: &[f64], pdf: &[f64], at: f64) -> f64 {
    let first = x.partition_point(|&place| place <= at);
    if first < 2 || first + 2 > x.len() {
        return 0.0;
    }
    let places = first - 2..first + 2;
    let basis = |i: usize| -> f64 {
        places.clone().filter(|&j| j != i).map(|j| (at - x[j]) / (x[i] - x[j])).product()
    };
    places.clone().map(|i| pdf[i] * basis(i)).sum()
}

fn bistable(context: &Context<'_>) -> CaseResult {
    let table = BistableReference::read()?;
    let well = Bistable::new(BistableParameters { growth: 1.0, cubic: 1.0, diffusion: 0.25 })?;
    let law = GaussianMixture::independent([0.5], [0.1])?;
    let exact = |t: f64, x: f64| {
        let at = table.times.iter().position(|time| (time - t).abs() < 1e-9);
        at.map_or(f64::NAN, |k| interpolated(&table.x, &table.pdf[k], x))
    };
    let (name, range) = ("bistable", (-3.0, 3.0));
    let asks = Asks { name, law: &law, range, times: &[0.5, 1.0], tolerances: &[4e-5, 1e-3] };
    let mut claims = density_on_a_line(context, well, &asks, exact)?;
    let errors = errors_on_a_line(well, &Asks { times: &[2.0], ..asks }, 100, exact)?;
    let method = format!("flow-map fit: 100 particles, {} steps", errors.steps);
    let lines = context.lines("bistable", method);
    let reason = "not reached: half of the probability has crossed the barrier, and the cells that it left behind are \
                  stretched over it, those at the rim squeezed below what the fit resolves";
    let error = errors.at.first().copied().unwrap_or(f64::NAN);
    claims.push(lines.of("density-l1/t2", "L1 error of psi").bounded(error, 0.2).because(reason));
    Ok(claims)
}
