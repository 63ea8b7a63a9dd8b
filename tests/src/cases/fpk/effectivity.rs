//! The error that a refinement states against the error that it makes: the effectivity index.

use fpk_sph::{Config, InitialLattice, Refinement, Simulation, refine};
use reference_problems::fpk::problem;
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::GeometricBrownianMotion;

use super::flow_map_fit;
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/effectivity",
    title: "Estimated over true error of second moments, three lattices finer by the square root of two",
    source: "Roache 1994; Oberkampf & Roy 2010; references of the scenes",
    cost: Profile::Default,
    run: Together(run),
};

/// An index from 0.5 to 2 is a good one.
const GOOD: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// A true error below this many errors of its reference is not known.
const KNOWN: f64 = 4.0;

fn run(context: &Context<'_>) -> CaseResult {
    let mut all = Vec::new();
    let mut claims = Vec::new();
    let mut take = |name: &str, indices: Vec<Index>, words: (&str, (f64, f64))| {
        all.extend(indices.iter().map(|index| index.value));
        claims.extend(of_scene(context, name, &indices, words));
    };
    // What is asked of all together.
    let asked = (0.8, 1.0);
    context.progress("Bouc-Wen");
    let reach = "what is left at t = 3 and 3.6, 0.1 to 0.4 %, comes from the reach of the ball, 5 sigma, as much as from the \
                 spacing, and does not show in the differences";
    take("bouc-wen/flow-map-fit", bouc_wen()?, (reach, (0.5, 1.0)));
    context.progress("geometric Brownian motion");
    let order_4 = "the cubic fit has the order 4 where the drift is smooth";
    take("geometric-brownian-motion/flow-map-fit", gbm()?, (order_4, asked));
    let share = share(&all);
    let method =
        format!("{} values of second moments, all scenes; the finest of three runs", all.len());
    let lines = context.lines("all", method);
    let claim = lines.of("share", "share of indices from 0.5 to 2").measured(share, asked);
    claims.push(claim.because("four of five are asked for"));
    Ok(claims)
}

/// The index of one moment at one time.
struct Index {
    name: String,
    value: f64,
}

fn share(indices: &[f64]) -> f64 {
    indices.iter().filter(|value| GOOD.contains(*value)).count() as f64 / indices.len() as f64
}

/// The share of good indices, and each of them.
fn of_scene(
    context: &Context<'_>,
    name: &str,
    indices: &[Index],
    (reason, band): (&str, (f64, f64)),
) -> Vec<Claim> {
    let words: Vec<String> =
        indices.iter().map(|index| format!("{} {:.2}", index.name, index.value)).collect();
    let values: Vec<f64> = indices.iter().map(|index| index.value).collect();
    let lines = context.lines(name, format!("estimated over true error: {}", words.join(", ")));
    vec![
        lines
            .of("share", "share of indices from 0.5 to 2")
            .measured(share(&values), band)
            .because(reason),
    ]
}

/// What is refined: where it starts, until when, and what is looked at.
struct Asks<'a, const D: usize> {
    law: &'a GaussianMixture<D>,
    config: Config<D>,
    /// The order in the spacing by theory.
    order: f64,
    /// Enough for three runs and too few for a fourth.
    most_particles: usize,
    times: &'a [f64],
    moments: &'a [(&'a str, [u32; D])],
}

/// Three runs, and the index wherever the true error of the finest is known.
fn indices<S: Sde<D, M> + Clone, const D: usize, const M: usize>(
    system: &S,
    asks: &Asks<'_, D>,
    exact: impl Fn([u32; D], f64) -> Option<Reference>,
) -> CaseResult<Vec<Index>> {
    // A tolerance that is never met: the particles end it.
    let &Asks { order, most_particles, .. } = asks;
    let refinement = Refinement { tolerance: 1e-12, order, most_particles };
    let refined = refine(asks.config.lattice, &refinement, |lattice| {
        let config = Config { lattice: *lattice, ..asks.config };
        let mut simulation = Simulation::new(system.clone(), asks.law, &config)?;
        let mut values = Vec::new();
        for &t in asks.times {
            simulation.advance_to(t)?;
            values.extend(asks.moments.iter().map(|&(_, powers)| simulation.raw_moment(powers)));
        }
        Ok((simulation.n_particles(), values))
    })?;
    let finest = refined.runs.last().ok_or("no run")?;
    let mut found = Vec::new();
    let mut values = refined.values.iter().zip(&finest.values);
    for &t in asks.times {
        for &(name, powers) in asks.moments {
            let (stated, &value) = values.next().ok_or("a value is missing")?;
            let Some(Reference { value: reference, error }) = exact(powers, t) else { continue };
            let made = (value - reference).abs();
            if made > KNOWN * error.unwrap_or(0.0) {
                found.push(Index { name: format!("{name} t{t}"), value: stated.error / made });
            }
        }
    }
    Ok(found)
}

fn bouc_wen() -> CaseResult<Vec<Index>> {
    let (system, law, reference) = problem::bouc_wen()?;
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: 0.85 };
    let config = flow_map_fit(lattice, system.period());
    let asks = Asks {
        law: &law,
        config,
        // The drift has kinks, at v = 0 and at z = 0.
        order: 2.0,
        most_particles: 10_000,
        times: &[1.0, 2.0, 3.0, 3.6],
        moments: &[("E[q^2]", [2, 0, 0]), ("E[v^2]", [0, 2, 0]), ("E[z^2]", [0, 0, 2])],
    };
    indices(&system, &asks, |powers, t| reference.moment(powers, t))
}

fn gbm() -> CaseResult<Vec<Index>> {
    let (growth, volatility, deviation) = (0.1, 0.3, 0.05);
    let system = GeometricBrownianMotion::new(growth, volatility)?;
    let law = GaussianMixture::independent([1.0], [deviation])?;
    // The reference period is the time in which the noise doubles the variance of the start.
    let config = flow_map_fit(InitialLattice::Box { reach: 6.0, count: [37] }, 0.03);
    let asks = Asks {
        law: &law,
        config,
        order: 4.0,
        most_particles: 80,
        times: &[0.25, 0.5],
        moments: &[("E[x]", [1]), ("E[x^2]", [2])],
    };
    indices(&system, &asks, |[power], t| {
        // E[X^a] = E[X_0^a] exp(a mu t + a (a - 1) sigma^2 t / 2); the box leaves out 2e-9 of the mass.
        let a = f64::from(power);
        let start = if power == 2 { 1.0 + deviation * deviation } else { 1.0 };
        let rate = a * growth + 0.5 * a * (a - 1.0) * volatility * volatility;
        let value = start * (rate * t).exp();
        Some(Reference::uncertain(value, 1e-8 * value))
    })
}
