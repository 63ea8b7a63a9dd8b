//! Multilevel Monte Carlo: cost against tolerance.

use reference_problems::order;
use reference_problems::sde::damper::viscous_damper_at_rest;
use sde_integrators::{
    EnsembleConfig, EulerMaruyama, Observable, StateSpace, StrangOscillator, simulate,
};
use uq_estimators::{
    Bias, Ladder, Multilevel, MultilevelResult, PathLadder, Statistic, Target, Tolerance,
};
use vibrating_systems::GeometricBrownianMotion;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "uq-estimators/multilevel-cost",
    title: "cost of multilevel Monte Carlo against its tolerance, in steps, beside plain Monte Carlo",
    source: "closed form of geometric Brownian motion; the damped oscillator by Strang's splitting; Giles 2008, theorem 3.1",
    cost: Profile::Default,
    run: Together(run),
};

/// Growth and volatility of the geometric Brownian motion, from 1 to time 1.
pub(super) const GROWTH: [f64; 2] = [1.0, 0.5];

fn study(targets: &[Target]) -> Multilevel<'_> {
    let bias = Bias::Order(1.0);
    Multilevel { name: "case", targets, bias, block_length: 64, pilot_blocks: 4, budget: 1e11 }
}

fn mean_to(tolerance: f64) -> [Target; 1] {
    let tolerance = Tolerance::Absolute(tolerance);
    [Target { response: 0, statistic: Statistic::Mean, tolerance }]
}

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = growth_claims(context)?;
    claims.extend(damper_claims(context)?);
    Ok(claims)
}

fn growth_claims(context: &Context<'_>) -> CaseResult {
    let system = GeometricBrownianMotion::new(GROWTH[0], GROWTH[1])?;
    let ladder = PathLadder::<_, _, _, _, 1, 1> {
        system: &system,
        integrator: &EulerMaruyama,
        law: &[1.0],
        seed: 61,
        end: 1.0,
        coarsest_steps: 1,
        n_levels: 14,
        n_responses: 1,
        responses: |x: &[f64; 1], y: &mut [f64]| y[0] = x[0],
    };
    let exact = GROWTH[0].exp();
    let tolerances = [1.6e-2, 8e-3, 4e-3, 2e-3, 1e-3].map(|relative| relative * exact);
    let results = refine(context, "growth", &ladder, &tolerances)?;
    let mut claims = slopes(context, "growth", &tolerances, &results)?;
    claims.push(value(context, "growth", &tolerances, &results, Reference::exact(exact)));
    if let Some(finest) = results.last() {
        let ratio = finest.single_level_cost / finest.cost;
        let quantity = "steps of plain over multilevel Monte Carlo at a relative error of 1e-3";
        let method = "Euler-Maruyama, steps doubling from 1";
        let reason = "at least 10 is asked; variances of a pilot move it by a few per cent";
        let subject = context.subject("growth/speed-up", quantity, method);
        claims.push(subject.measured(ratio, (25.0, 60.0)).because(reason));
    }
    Ok(claims)
}

fn damper_claims(context: &Context<'_>) -> CaseResult {
    let (system, end) = (viscous_damper_at_rest()?, 2.0);
    let ladder = PathLadder::<_, _, _, _, 2, 1> {
        system: &StateSpace(system.clone()),
        integrator: &EulerMaruyama,
        law: &[0.0; 2],
        seed: 62,
        end,
        coarsest_steps: 16,
        n_levels: 12,
        n_responses: 1,
        responses: |x: &[f64; 2], y: &mut [f64]| y[0] = x[0] * x[0],
    };
    context.progress("damper: reference");
    let config = EnsembleConfig { seed: 63, n_paths: 131_072, dt: 0.01, times: vec![end] };
    let square = [Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0])];
    let strang = simulate(&system, &StrangOscillator, &[0.0; 2], &config, &square)?;
    let strang = strang.estimates[0][0];
    let tolerances = [3.2e-2, 1.6e-2, 8e-3, 4e-3].map(|relative| relative * strang.value);
    let results = refine(context, "damper", &ladder, &tolerances)?;
    let mut claims = slopes(context, "damper", &tolerances, &results)?;
    claims.push(value(context, "damper", &tolerances, &results, estimated(&strang)));
    Ok(claims)
}

fn refine(
    context: &Context<'_>,
    name: &str,
    ladder: &impl Ladder,
    tolerances: &[f64],
) -> CaseResult<Vec<MultilevelResult>> {
    let mut results = Vec::new();
    for tolerance in tolerances {
        context.progress(&format!("{name}: tolerance {tolerance:.1e}"));
        results.push(study(&mean_to(*tolerance)).run(ladder)?);
    }
    Ok(results)
}

/// Slopes of the cost against the tolerance.
fn slopes(
    context: &Context<'_>,
    name: &str,
    tolerances: &[f64],
    results: &[MultilevelResult],
) -> CaseResult {
    let claim = |id: &str, cost: &dyn Fn(&MultilevelResult) -> f64, expected: f64| {
        let levels: Vec<(f64, f64)> =
            tolerances.iter().zip(results).map(|(eps, found)| (*eps, cost(found))).collect();
        let reason = "statistics: a whole number of levels, sampled variances, the logarithm in the cost, the pilot";
        let (kind, expected) = (ErrorKind::Order, Reference::exact(expected));
        order::fit(&levels).map(|found| {
            let quantity = "slope of the steps against the tolerance";
            let method = "tolerances halved, costs in steps, the pilot included";
            let subject = context.subject(format!("{name}/{id}"), quantity, method);
            subject.compared(kind, found, expected).within(0.35).because(reason)
        })
    };
    Ok(vec![
        claim("multilevel-slope", &|found| found.cost, -2.0)?,
        claim("plain-slope", &|found| found.single_level_cost, -3.0)?,
    ])
}

/// The mean at the smallest tolerance.
fn value(
    context: &Context<'_>,
    name: &str,
    tolerances: &[f64],
    results: &[MultilevelResult],
    reference: Reference,
) -> Claim {
    let (found, tolerance) = match (results.last(), tolerances.last()) {
        (Some(result), Some(tolerance)) => (result.targets[0], *tolerance),
        _ => return Claim::case_error(name, "no tolerances"),
    };
    let standard_error = found.estimate.standard_error().unwrap_or(f64::NAN);
    let method = format!("tolerance {tolerance:.1e}, reached: {}", found.is_reached);
    let bias_bound = tolerance * std::f64::consts::FRAC_1_SQRT_2;
    let reason = "half of the squared tolerance is for the bias";
    let value = Measured::sampled(found.estimate.value, standard_error);
    let subject = context.subject(format!("{name}/mean"), "mean of the response", &method);
    subject.absolute(value, reference).monte_carlo(bias_bound).because(reason)
}
