//! A mixture of two Gaussians in the linear oscillator: not Gaussian, and known exactly at all times.

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};
use reference_problems::fpk::mixture::{MixtureLaw, mixture_laws};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::Problem;
use reference_problems::order;
use scenes::fpk::density::estimate;
use sde_integrators::{GaussianComponent, GaussianMixture, Sde};

use super::worst;
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/gaussian-mixture",
    title: "Linear oscillator in an earthquake from a mixture of two Gaussians: exact, not Gaussian",
    source: "Canor & Denoël 2013, eq 26 with eta = 0; Lyapunov equation for each component",
    cost: Profile::Default,
    run: Together(run),
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

/// Names and quantities of moments and density.
const NAMES: [(&str, &str); 4] = [
    ("second-moment-q", "E[q^2]"),
    ("second-moment-v", "E[v^2]"),
    ("fourth-moment-q", "E[q^4]"),
    ("density-l2", "relative L2 error of psi"),
];
const ID: &str = "flow-map-fit";
/// Of `E[q^2]`, `E[v^2]`, `E[q^4]`, the density and log10 P.
const TOLERANCES: [f64; 5] = [2e-4, 1e-3, 1e-3, 6e-3, 5e-3];
const REASON: &str = "truncation of the cubic fit, of third to fourth order in the spacing";

fn run(context: &Context<'_>) -> CaseResult {
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
    let mut claims = accuracy(context, (system, &start), &laws)?;
    claims.push(order_in_space(context, (system, &start), &laws)?);
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
    laws: &[MixtureLaw],
) -> CaseResult {
    let config = config(Method::FlowMapFit, COUNT, 2.0);
    let mut simulation = Simulation::new(system.clone(), start, &config)?;
    let mut families: [Vec<Claim>; 5] = std::array::from_fn(|_| Vec::new());
    let least = laws.iter().map(kurtosis).fold(f64::INFINITY, f64::min);
    let words = format!("{ID}, box of {REACH} sigma, {COUNT}^2 particles");
    let lines = context.lines(ID, format!("{words}; E[q^4]/E[q^2]^2 down to {least:.2}"));
    for law in laws {
        simulation.advance_to(law.t)?;
        let density = simulation.density_error(|x| law.law.density(x))?;
        let moment = |q, v, exact| (ErrorKind::Relative, simulation.raw_moment([q, v]), exact);
        let values = [
            moment(2, 0, law.moment(0, 2)),
            moment(0, 2, law.moment(1, 2)),
            moment(4, 0, law.moment(0, 4)),
            (ErrorKind::Absolute, density, 0.0),
        ];
        for (k, ((name, quantity), (kind, value, exact))) in
            NAMES.into_iter().zip(values).enumerate()
        {
            let compared =
                lines.of(format!("{name}/t{}", law.t), quantity).compared(kind, value, exact);
            families[k].push(compared.within(TOLERANCES[k]).because(REASON));
        }
        families[4].extend(tail(&lines, &simulation, law)?);
    }
    let names = NAMES.map(|(name, _)| name).into_iter().chain(["exceedance-cell"]);
    let over = format!("t = {TIMES:?}");
    names
        .zip(families)
        .map(|(name, family)| worst(context, (&format!("{ID}/{name}/worst"), &over), family))
        .collect()
}

/// `P(|q| > T)` by cells at one time, where it is at least the floor.
fn tail<S: Sde<2, 1>>(
    lines: &Lines<'_>,
    simulation: &Simulation<S, 2, 1>,
    law: &MixtureLaw,
) -> CaseResult {
    let cells = simulation.cell_integral()?;
    let mut claims = Vec::new();
    for threshold in [0.25, 0.5, 0.75, 1.0, 1.25, 1.5] {
        let exact = law.exceedance(threshold);
        if exact < FLOOR {
            continue;
        }
        let value = estimate(cells.exceedance(|x| x[0].abs(), threshold)?.probability());
        let name = format!("exceedance-cell/threshold-{threshold}/t{}", law.t);
        let subject = lines.of(name, format!("P(|q| > {threshold}) >= {FLOOR:e}"));
        let compared = subject.log10(value, exact);
        claims.push(compared.within(TOLERANCES[4]).because(REASON));
    }
    Ok(claims)
}

/// The order in which the L2 error of the density falls with the spacing.
fn order_in_space<S: Sde<2, 1> + Clone>(
    context: &Context<'_>,
    (system, start): (&S, &GaussianMixture<2>),
    laws: &[MixtureLaw],
) -> CaseResult<Claim> {
    let exact = laws.iter().find(|law| (law.t - ORDER_TIME).abs() < 1e-9).ok_or("no such time")?;
    let mut levels = Vec::new();
    for count in COUNTS {
        // Steps of a hundredth of the period of 2: their error is below 1e-6.
        let mut combination = Method::FlowMapFit.combination();
        combination.step = fpk_sph::StepRule::PeriodFraction { steps_per_period: 100.0 };
        let config = config(Method::Custom(combination), count, 2.0);
        let mut simulation = Simulation::new(system.clone(), start, &config)?;
        simulation.advance_to(ORDER_TIME)?;
        let error = simulation.density_error(|x| exact.law.density(x))?;
        levels.push((2.0 * REACH / (count as f64 - 1.0), error));
    }
    let errors: Vec<String> = levels.iter().map(|level| format!("{:.1e}", level.1)).collect();
    let quantity = "order of the L2 error of psi at t = 2";
    let method = format!("{ID}, {COUNTS:?} particles a side: {}", errors.join(", "));
    let subject = context.subject(format!("{ID}/density-l2/order"), quantity, method);
    let reason =
        "the density is that of first derivatives of a cubic: order 4 inside and 3 at the rim";
    Ok(subject.order(order::fit(&levels)?, 2.0).as_measured(1.1, 2.0).because(reason))
}
