//! A mixture of two Gaussians in the linear oscillator: not Gaussian, and known exactly at all times.

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};
use reference_problems::fpk::mixture::{MixtureLaw, mixture_laws};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::Problem;
use reference_problems::order;
use result_figures::{ErrorKind, Measured, Reference};
use scenes::fpk::density::estimate;
use sde_integrators::{GaussianComponent, GaussianMixture, Sde};

use super::worst;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::{Criterion, Subject};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/gaussian-mixture",
    title: "Linear oscillator in an earthquake from a mixture of two Gaussians: exact, not Gaussian",
    source: "Canor & Denoël 2013, eq 26 with eta = 0; Lyapunov equation for each component",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

const TIMES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Smallest probability that is claimed.
const FLOOR: f64 = 1e-7;
/// Particles along each axis of the claims, and of the runs that show the order.
const COUNT: usize = 61;
const COUNTS: [usize; 4] = [31, 41, 53, 69];
/// When they show it.
const ORDER_TIME: f64 = 2.0;
const REACH: f64 = 6.0;

/// What is asked of a method.
struct Asks {
    id: &'static str,
    method: Method,
    /// Of `E[q^2]`, `E[v^2]`, `E[q^4]`, the density and log10 P.
    tolerances: [f64; 5],
    /// Of the order in the spacing against 2.
    order: Criterion<'static>,
    reason: &'static str,
}

const ASKS: Asks = Asks {
    id: "flow-map-fit",
    method: Method::FlowMapFit,
    tolerances: [2e-4, 1e-3, 1e-3, 6e-3, 5e-3],
    order: Criterion::AsMeasured {
        from: 1.1,
        to: 2.0,
        reason: "the density is that of first derivatives of a cubic: order 4 inside and 3 at the rim",
    },
    reason: "truncation of the cubic fit, of third to fourth order in the spacing",
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::linear_oscillator()?;
    let Oscillator::Linear(system) = &problem.system else {
        return Err("the scene holds another system".into());
    };
    let covariance = [[0.0225, 0.0], [0.0, 0.01]];
    let start = GaussianMixture::mixture(&[
        GaussianComponent { weight: 0.6, mean: [0.2, 0.0], covariance },
        GaussianComponent { weight: 0.4, mean: [-0.3, 0.2], covariance },
    ])?;
    let laws = mixture_laws(system, &start, &TIMES, 1e-3)?;
    let mut claims = accuracy(context, (system, &start), &ASKS, &laws)?;
    claims.push(order_in_space(context, (system, &start), &ASKS, &laws)?);
    Ok(claims)
}

fn config(method: Method, count: usize, reference_period: f64) -> Config<2> {
    let lattice = InitialLattice::Box { reach: REACH, count: [count; 2] };
    Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS }
}

/// The kurtosis of `q`, 3 for a Gaussian.
fn kurtosis(law: &MixtureLaw) -> f64 {
    law.moment(0, 4) / law.moment(0, 2).powi(2)
}

fn accuracy<S: Sde<2, 1> + Clone>(
    context: &Context<'_>,
    (system, start): (&S, &GaussianMixture<2>),
    asks: &Asks,
    laws: &[MixtureLaw],
) -> Result<Vec<Claim>, CaseError> {
    let config = config(asks.method, COUNT, 2.0);
    let mut simulation = Simulation::new(system.clone(), start, &config)?;
    let mut families: [Vec<Claim>; 5] = std::array::from_fn(|_| Vec::new());
    let least = laws.iter().map(kurtosis).fold(f64::INFINITY, f64::min);
    let words = format!("{}, box of {REACH} sigma, {COUNT}^2 particles", asks.id);
    let method = format!("{words}; E[q^4]/E[q^2]^2 down to {least:.2}");
    let lines = Lines { context, id: asks.id, method };
    for law in laws {
        simulation.advance_to(law.t)?;
        let density = simulation.density_error(|x| law.law.density(x))?;
        let relative = ErrorKind::Relative;
        let q = law.moment(0, 2);
        for (k, (name, quantity, kind, value, exact)) in [
            ("second-moment-q", "E[q^2]", relative, simulation.raw_moment([2, 0]), q),
            (
                "second-moment-v",
                "E[v^2]",
                relative,
                simulation.raw_moment([0, 2]),
                law.moment(1, 2),
            ),
            (
                "fourth-moment-q",
                "E[q^4]",
                relative,
                simulation.raw_moment([4, 0]),
                law.moment(0, 4),
            ),
            ("density-l2", "relative L2 error of psi", ErrorKind::Absolute, density, 0.0),
        ]
        .into_iter()
        .enumerate()
        {
            let name = format!("{name}/t{}", law.t);
            let criterion =
                Criterion::Within { tolerance: asks.tolerances[k], reason: asks.reason };
            let what = (name.as_str(), quantity, "");
            families[k].push(lines.judge(what, kind, value, Reference::exact(exact), criterion));
        }
        families[4].extend(tail(&lines, &simulation, law, asks)?);
    }
    let names =
        ["second-moment-q", "second-moment-v", "fourth-moment-q", "density-l2", "exceedance-cell"];
    let over = format!("t = {TIMES:?}");
    let named = names.into_iter().zip(families);
    named
        .map(|(name, family)| worst(context, (&format!("{}/{name}/worst", asks.id), &over), family))
        .collect()
}

/// `P(|q| > T)` by cells at one time, where it is at least the floor.
fn tail<S: Sde<2, 1>>(
    lines: &Lines<'_>,
    simulation: &Simulation<S, 2, 1>,
    law: &MixtureLaw,
    asks: &Asks,
) -> Result<Vec<Claim>, CaseError> {
    let cells = simulation.cell_integral()?;
    let mut claims = Vec::new();
    for threshold in [0.25, 0.5, 0.75, 1.0, 1.25, 1.5] {
        let exact = law.exceedance(threshold);
        if exact < FLOOR {
            continue;
        }
        let value = estimate(cells.exceedance(|x| x[0].abs(), threshold)?.probability());
        let name = format!("exceedance-cell/threshold-{threshold}/t{}", law.t);
        let quantity = format!("P(|q| > {threshold}) >= {FLOOR:e}");
        let criterion = Criterion::Within { tolerance: asks.tolerances[4], reason: asks.reason };
        let (what, exact) = ((name.as_str(), quantity.as_str(), ""), Reference::exact(exact));
        claims.push(lines.judge(what, ErrorKind::Log10, value, exact, criterion));
    }
    Ok(claims)
}

/// The order in which the L2 error of the density falls with the spacing.
fn order_in_space<S: Sde<2, 1> + Clone>(
    context: &Context<'_>,
    (system, start): (&S, &GaussianMixture<2>),
    asks: &Asks,
    laws: &[MixtureLaw],
) -> Result<Claim, CaseError> {
    let exact = laws.iter().find(|law| (law.t - ORDER_TIME).abs() < 1e-9).ok_or("no such time")?;
    let mut levels = Vec::new();
    for count in COUNTS {
        // Steps of a hundredth of the period of 2: their error is below 1e-6.
        let mut combination = asks.method.combination();
        combination.step = fpk_sph::StepRule::PeriodFraction { steps_per_period: 100.0 };
        let config = config(Method::Custom(combination), count, 2.0);
        let mut simulation = Simulation::new(system.clone(), start, &config)?;
        simulation.advance_to(ORDER_TIME)?;
        let error = simulation.density_error(|x| exact.law.density(x))?;
        levels.push((2.0 * REACH / (count as f64 - 1.0), error));
    }
    let errors: Vec<String> = levels.iter().map(|level| format!("{:.1e}", level.1)).collect();
    let subject: Subject = context.subject(
        &format!("{}/density-l2/order", asks.id),
        "order of the L2 error of psi at t = 2",
        "",
        &format!("{}, {COUNTS:?} particles a side: {}", asks.id, errors.join(", ")),
    );
    let order: Measured = order::fit(&levels)?;
    Ok(Claim::judge(subject, ErrorKind::Order, order, Reference::exact(2.0), asks.order))
}
