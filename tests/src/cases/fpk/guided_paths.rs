//! Guided paths: unbiased at 1e-3 to 1e-9, intervals that hold, first passage, refusals, threads.

use random_vibration::{GuidedConfig, GuidedEstimate, GuidedPaths, TailError, Tails};
use reference_problems::fpk::linear_moments::linear_moments;
use reference_problems::fpk::methods::{OF_HYSTERESIS, OF_OSCILLATOR};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::{Problem, bouc_wen};
use scenes::fpk::paths::{Paths, PathsError};
use sde_integrators::{Between, GaussianMixture, Response, Side, normal_probability};
use vibrating_systems::ViscousDamper;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/guided-paths",
    title: "Paths guided to the rare event by a linearised backward function",
    source: "exact linear oscillator; references of the damper and of Bouc-Wen; Macke & Bucher 2003",
    cost: Profile::Default,
    run: Together(run),
};

/// 20,000 paths, 1,000 pilot paths, a twentieth without a guide.
const CONFIG: GuidedConfig =
    GuidedConfig { n_paths: 20_000, n_pilots: 1_000, unguided: 0.05, seed: 11 };
const METHOD: &str = "20,000 guided paths, 1,000 pilot paths";
/// The displacement, with a cubic between the ends of a step.
const fn response() -> Response<'static> {
    let between = Between::CubicHermite { velocity: 1 };
    Response { component: 0, side: Side::Magnitude, between }
}

/// Guided paths of an oscillator; what they simulate is compiled with `scenes`.
fn of_oscillator<'a, S: Paths<2, 1>>(
    system: &'a S,
    law: &GaussianMixture<2>,
    span: (f64, usize),
) -> Result<GuidedPaths<'a>, PathsError> {
    system.guided(law, span, &OF_OSCILLATOR)
}

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = linear(context)?;
    context.progress("damper");
    let problem = Problem::viscous_damper()?;
    let Oscillator::Damper(system) = &problem.system else { return Err("another system".into()) };
    claims.extend(damper(context, &problem, system)?);
    context.progress("hysteresis");
    claims.extend(hysteresis(context)?);
    context.progress("refusals");
    claims.extend(refusals(context, &problem, system)?);
    let paths = of_oscillator(system, &problem.law, (6.0, 60))?;
    let whole = || -> CaseResult<Vec<u64>> {
        let at_time = paths.exceedance(1.0, Tails::Both, &CONFIG)?;
        let passage = paths.first_passage(&response(), 1.0, &CONFIG)?;
        let all = [at_time, passage].map(|found| -> CaseResult<[u64; 3]> {
            let error = found.estimate.standard_error().ok_or("no standard error")?;
            Ok([found.estimate.value, error, found.largest_share].map(f64::to_bits))
        });
        Ok(all.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
    };
    let reason = "a path is a function of seed and realisation, and blocks of 4,096 paths are summed in order";
    claims.extend(super::over_threads(context, "viscous-damper", reason, whole)?);
    Ok(claims)
}

/// A probability against its reference.
fn against(
    context: &Context<'_>,
    (id, quantity): (&str, &str),
    found: &GuidedEstimate,
    reference: impl Into<Reference>,
    (bias_bound, reason): (f64, &str),
) -> CaseResult<Claim> {
    let subject = context.subject(id, quantity, METHOD);
    let compared = subject.relative(sampled(&found.estimate)?, reference);
    Ok(compared.monte_carlo(bias_bound).because(reason))
}

/// The linear oscillator at 1e-3, 1e-6 and 1e-9, and the intervals of 200 runs of 1,000 paths.
fn linear(context: &Context<'_>) -> CaseResult {
    let problem = Problem::linear_oscillator()?;
    let Oscillator::Linear(system) = &problem.system else { return Err("another system".into()) };
    let law = linear_moments(system, &problem.law, &[6.0], 2e-3)?[0];
    let deviation = law.covariance[0][0].sqrt();
    let of = |n_steps| of_oscillator(system, &problem.law, (6.0, n_steps));
    let paths = of(600)?;
    let mut claims = Vec::new();
    for (z, name) in [(3.3, "1e-3"), (4.9, "1e-6"), (6.1, "1e-9")] {
        context.progress(&format!("linear oscillator, {name}"));
        let found = paths.exceedance(z * deviation, Tails::Both, &CONFIG)?;
        let exact = 2.0 * normal_probability(-z);
        let bias = "600 Strang steps: (omega dt)^2/12 = 8e-5 of the variance, times z^2/2 = 19";
        let id = format!("linear-oscillator/exceedance/p-{name}/t6");
        claims.push(against(context, (&id, "P(|q| > T)"), &found, exact, (2e-3, bias))?);
    }
    // Fine enough that the bias is a tenth of the standard error of 1,000 paths.
    let paths = of(300)?;
    let z = 4.9;
    context.progress("intervals");
    let id = "linear-oscillator/coverage/p-1e-6/t6";
    let exact = 2.0 * normal_probability(-z);
    claims.push(coverage(context, id, &paths, (z * deviation, exact))?);
    Ok(claims)
}

/// The share of the intervals of 200 runs that contain the probability of a threshold.
fn coverage(
    context: &Context<'_>,
    id: &str,
    paths: &GuidedPaths<'_>,
    (threshold, probability): (f64, f64),
) -> CaseResult<Claim> {
    let (mut inside, n) = (0, 200);
    for seed in 0..n {
        let config = GuidedConfig { n_paths: 1_000, n_pilots: 200, seed, ..CONFIG };
        let found = sampled(&paths.exceedance(threshold, Tails::Both, &config)?.estimate)?;
        let half_width = 1.96 * found.standard_error.unwrap_or(f64::NAN);
        inside += u32::from((found.value - probability).abs() < half_width);
    }
    let quantity = "share of 95 % intervals that contain the reference";
    let method = "200 runs of 1,000 guided paths";
    let reason = "statistics: the share of 200 intervals scatters by 0.015";
    let share = f64::from(inside) / n as f64;
    Ok(context.subject(id, quantity, method).absolute(share, 0.95).within(0.03).because(reason))
}

fn damper(context: &Context<'_>, problem: &Problem, system: &ViscousDamper) -> CaseResult {
    let t = 6.0;
    let paths = of_oscillator(system, &problem.law, (t, 300))?;
    let mut claims = Vec::new();
    for threshold in [0.75, 1.25, 1.5] {
        let found = paths.exceedance(threshold, Tails::Both, &CONFIG)?;
        let reference = problem.reference.exceedance(threshold, t).ok_or("no reference")?;
        let id = format!("viscous-damper/exceedance/threshold-{threshold}/t{t}");
        let bias = "300 Strang steps: (omega dt)^2/12 = 3e-4 of the variance, times z^2/2 = 17";
        let quantity = format!("P(|q| > {threshold})");
        claims.push(against(context, (&id, &quantity), &found, reference, (5e-3, bias))?);
    }
    for threshold in [0.75, 1.0] {
        let found = paths.first_passage(&response(), threshold, &CONFIG)?;
        let reference = problem.reference.first_passage(threshold, t).ok_or("no reference")?;
        claims.push(passage(context, ("viscous-damper", threshold, t), &found, reference)?);
    }
    let reference = problem.reference.exceedance(0.75, t).ok_or("no reference")?.value;
    let id = "viscous-damper/coverage/threshold-0.75/t6";
    claims.push(coverage(context, id, &paths, (0.75, reference))?);
    Ok(claims)
}

/// `P(max |q| > T)` up to a time.
fn passage(
    context: &Context<'_>,
    (scene, threshold, t): (&str, f64, f64),
    found: &GuidedEstimate,
    reference: Reference,
) -> CaseResult<Claim> {
    let id = format!("{scene}/first-passage/threshold-{threshold}/t{t}");
    let bias = "maxima by a cubic through the ends of a step of a hundredth of the period; the reference by parabolas";
    let quantity = format!("P(max |q| > {threshold})");
    against(context, (&id, &quantity), found, reference, (5e-3, bias))
}

fn hysteresis(context: &Context<'_>) -> CaseResult {
    let (system, law, reference) = bouc_wen()?;
    let t = 3.6;
    let paths = system.guided(&law, (t, 180), &OF_HYSTERESIS)?;
    let mut claims = Vec::new();
    for threshold in [1.5, 2.0, 2.5] {
        let found = paths.exceedance(threshold, Tails::Both, &CONFIG)?;
        let expected = reference.exceedance(threshold, t).ok_or("no reference")?;
        let id = format!("bouc-wen/exceedance/threshold-{threshold}/t{t}");
        let quantity = format!("P(|q| > {threshold})");
        let bias = "180 Strang steps: (omega dt)^2/12 = 3e-4 of the variance, times z^2/2 = 19";
        claims.push(against(context, (&id, &quantity), &found, expected, (6e-3, bias))?);
    }
    for threshold in [1.5, 2.0] {
        let found = paths.first_passage(&response(), threshold, &CONFIG)?;
        let expected = reference.first_passage(threshold, t).ok_or("no reference")?;
        claims.push(passage(context, ("bouc-wen", threshold, t), &found, expected)?);
    }
    Ok(claims)
}

/// Runs whose standard error would mean nothing.
fn refusals(context: &Context<'_>, problem: &Problem, system: &ViscousDamper) -> CaseResult {
    let paths = of_oscillator(system, &problem.law, (6.0, 150))?;
    let mut claims = Vec::new();
    for (name, threshold, n_paths, reason) in [
        ("few-paths", 1.5, 40, "40 paths have an effective sample size of some 20, 50 are needed"),
        ("no-weight", 15.0, 2_000, "at 70 deviations every weight is below the smallest number"),
    ] {
        let config = GuidedConfig { n_paths, ..CONFIG };
        let found = paths.exceedance(threshold, Tails::Both, &config);
        let is_refused = matches!(found, Err(TailError::Untrusted { .. }));
        let quantity = "1 if the run is refused";
        let method = format!("{n_paths} guided paths, T = {threshold}");
        let refused = f64::from(u8::from(is_refused));
        let subject = context.subject(format!("viscous-damper/refused/{name}"), quantity, &method);
        claims.push(subject.absolute(refused, 1.0).within(0.0).because(reason).structural());
    }
    Ok(claims)
}
