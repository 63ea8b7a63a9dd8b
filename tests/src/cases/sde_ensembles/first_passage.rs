//! First passage: what happens between the steps, by the right rule and by the wrong ones.

use result_figures::{ErrorKind, Reference};
use sde_integrators::{
    Additive, Between, EnsembleConfig, Estimate, EulerMaruyama, GaussianMixture, Response, Sde,
    Side, StrangOscillator, maxima,
};

use super::{Oscillator, against_exact, sampled, upper_tail};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/ensembles/first-passage",
    title: "First passage between the steps: bridges for a component with diffusion, cubics for an oscillator",
    source: "reflection principle; step halving",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = brownian_motion(context)?;
    claims.extend(oscillator(context)?);
    Ok(claims)
}

/// `dX = s dB`.
struct BrownianMotion;

const INTENSITY: f64 = 0.7;

impl Sde<1, 1> for BrownianMotion {
    type Noise = Additive;

    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[INTENSITY]]
    }
}

/// `P(max X > b) = 2 P(X(T) > b)`, and the quantiles of the maximum, with eight steps only.
fn brownian_motion(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    const N_STEPS: f64 = 8.0;
    let config = EnsembleConfig { seed: 17, n_paths: 100_000, dt: 1.0 / N_STEPS, times: vec![1.0] };
    let level = 1.2 * INTENSITY;
    let exact = 2.0 * upper_tail(1.2);
    let run = |between| {
        let response = Response { component: 0, side: Side::Above, between };
        maxima(&BrownianMotion, &EulerMaruyama, &[0.0], &config, &response)
    };
    let bridge = run(Between::BrownianBridge { intensity: &|_, _| INTENSITY })?;
    let ends = run(Between::Endpoints)?;
    let method = "Euler, 8 steps, 100,000 paths";
    let passage = bridge[0].exceedance(level)?;
    let median = bridge[0].quantile(0.5)?;
    let exact_reason = "exact for constant drift and diffusion";
    let mut claims = vec![
        against_exact(
            context,
            ("brownian/bridge", "P(max X > 1.2 s)", method),
            &passage,
            exact,
            (0.0, exact_reason),
        )?,
        against_exact(
            context,
            ("brownian/median", "median of max X", method),
            &median,
            // P(|Z| > x) = 1/2
            INTENSITY * 0.674489750196082,
            (0.0, exact_reason),
        )?,
    ];
    claims.push(shifted_barrier(context)?);
    claims.push(misses(context, "brownian/endpoints-miss", &ends[0].exceedance(level)?, &passage)?);
    Ok(claims)
}

/// Watched at the ends of steps, the barrier is as if `0.5826 s sqrt(h)` higher (Broadie, Glasserman and Kou 1997, A
/// continuity correction for discrete barrier options).
fn shifted_barrier(context: &Context<'_>) -> Result<Claim, CaseError> {
    let n_steps = 128.0_f64;
    let config = EnsembleConfig { seed: 18, n_paths: 50_000, dt: 1.0 / n_steps, times: vec![1.0] };
    let response = Response { component: 0, side: Side::Above, between: Between::Endpoints };
    let maxima = maxima(&BrownianMotion, &EulerMaruyama, &[0.0], &config, &response)?;
    against_exact(
        context,
        (
            "brownian/endpoints",
            "P(max X > 1.2 s) by the ends of steps",
            "Euler, 128 steps, 50,000 paths",
        ),
        &maxima[0].exceedance(1.2 * INTENSITY)?,
        2.0 * upper_tail(1.2 + 0.5826 / n_steps.sqrt()),
        (
            0.005,
            "the shift is a first term in sqrt(h); what is left falls as h, and is 6 % with 8 steps",
        ),
    )
}

/// A wrong rule is off by at least ten standard errors: that the right one is right is thereby worth saying.
fn misses(
    context: &Context<'_>,
    name: &str,
    wrong: &Estimate,
    right: &Estimate,
) -> Result<Claim, CaseError> {
    let (wrong, right) = (sampled(wrong)?, sampled(right)?);
    let spread = wrong.standard_error.unwrap_or(0.0).hypot(right.standard_error.unwrap_or(0.0));
    let distance = (wrong.value - right.value).abs() / spread;
    let subject = context.subject(
        name,
        "wrong rules within ten standard errors of the right one",
        "",
        &format!("one rule, {distance:.0} standard errors away"),
    );
    let is_told = distance >= 10.0;
    let reason = "the test must distinguish the wrong rule from the correct one";
    Ok(Claim::same_bits(subject, usize::from(!is_told), 1, reason))
}

const OSCILLATOR: Oscillator = Oscillator { omega: 2.0, xi: 0.05, intensity: 1.0 };

fn passage(between: Between<'_>, dt: f64, seed: u64, n_paths: u64) -> Result<Estimate, CaseError> {
    let deviation = OSCILLATOR.stationary_variance().sqrt();
    let law = GaussianMixture::independent([0.0; 2], [deviation, deviation * OSCILLATOR.omega])?;
    let config = EnsembleConfig { seed, n_paths, dt, times: vec![9.6] };
    let response = Response { component: 0, side: Side::Magnitude, between };
    let maxima = maxima(&OSCILLATOR, &StrangOscillator, &law, &config, &response)?;
    Ok(maxima[0].exceedance(2.2 * deviation)?)
}

/// Three periods of a stationary oscillator, `P(max |q| > 2.2 deviations)`: eight steps to a period against 128.
fn oscillator(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    const COARSE: f64 = 0.4;
    let hermite = Between::CubicHermite { velocity: 1 };
    let fine = passage(hermite, COARSE / 16.0, 5, 60_000)?;
    let reference = sampled(&fine)?;
    let reference =
        Reference::uncertain(reference.value, reference.standard_error.unwrap_or(f64::NAN));
    let quantity = "P(max |q| > 2.2 deviations)";
    let mut claims = Vec::new();
    for (name, between, dt, bias_bound) in [
        ("hermite", hermite, COARSE, 0.01),
        ("hermite-halved", hermite, 0.5 * COARSE, 0.0025),
        ("arc", Between::RotationArc { natural_frequency: OSCILLATOR.omega }, COARSE, 0.01),
    ] {
        let estimate = passage(between, dt, 6, 100_000)?;
        claims.push(Claim::judge(
            context.subject(
                &format!("oscillator/{name}"),
                quantity,
                "",
                &format!("Strang, h = {dt}, 100,000 paths, against h = 0.025"),
            ),
            ErrorKind::Relative,
            sampled(&estimate)?,
            reference,
            Criterion::MonteCarlo {
                bias_bound,
                reason: "the kicks within a step are not in the curve, an error of second order; less than can be seen here",
            },
        ));
    }
    let ends = passage(Between::Endpoints, COARSE, 6, 100_000)?;
    claims.push(misses(context, "oscillator/endpoints-miss", &ends, &fine)?);
    let intensity = |_: f64, _: &[f64]| OSCILLATOR.intensity;
    let bridge = passage(Between::BrownianBridge { intensity: &intensity }, COARSE, 6, 100_000)?;
    claims.push(misses(context, "oscillator/bridge-fails", &bridge, &fine)?);
    Ok(claims)
}
