//! A shear building of ten storeys: exact where it is linear, crude Monte Carlo where it yields, rare passages by guided paths.

use random_vibration::{
    GuidedConfig, GuidedEstimate, GuidedPaths, PairwiseRule, PassageQuestion, Tails, free_passages,
};
use scenes::SceneFile;
use scenes::building::scene::PassageScene;
use sde_integrators::{Between, LaneSde, Response, Side, normal_probability};
use vibrating_systems::{Hysteresis, ShearBuilding, ShearBuildingParameters};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/shear-building",
    title: "First passages of a building of ten yielding storeys, 32 states, by guided paths",
    source: "exact distribution of the linear building; crude Monte Carlo of the yielding one",
    cost: Profile::Default,
    run: Together(run),
};

const CONFIG: GuidedConfig =
    GuidedConfig { n_paths: 5_000, n_pilots: 300, unguided: 0.05, seed: 11 };
const METHOD: &str = "5,000 guided paths, 300 pilot paths";
/// For the thresholds of the scene.
const RARE_CONFIG: GuidedConfig = GuidedConfig { n_paths: 12_000, ..CONFIG };
const RARE_METHOD: &str = "12,000 guided paths, 300 pilot paths";
/// Duration and number of steps.
const SPAN: (f64, usize) = (10.0, 1_000);
/// Steps over which a guide is held: a thirty-fourth of the fundamental period, 0.69 s.
const HOLD: usize = 2;

/// The building of the scene, with other hysteresis if one is given.
fn building(hysteresis: Option<Hysteresis>) -> CaseResult<ShearBuilding> {
    let text = include_str!("../../../scenes/fpk/ten_storeys.json");
    let file = SceneFile::from_text("tests/scenes/fpk/ten_storeys.json", text.to_owned())?;
    let (_, building) = file.build::<PassageScene>()?;
    let mut parameters: ShearBuildingParameters = building.parameters().clone();
    if let Some(hysteresis) = hysteresis {
        for storey in &mut parameters.storeys {
            storey.hysteresis = hysteresis;
        }
    }
    Ok(ShearBuilding::new(parameters)?)
}

/// The drift of the first storey, with a cubic between the ends of a step.
fn response(building: &ShearBuilding) -> Response<'static> {
    let between = Between::CubicHermite { velocity: building.n_storeys() };
    Response { component: 0, side: Side::Magnitude, between }
}

fn guided(building: &ShearBuilding) -> CaseResult<GuidedPaths<'_>> {
    let unmodelled = if building.is_hysteretic() { 0.25 } else { 0.0 };
    let step = building.shortest_period() / 10.0;
    let rule = PairwiseRule { step, hold: HOLD, unmodelled };
    Ok(GuidedPaths::from_rest(building, SPAN, &rule)?)
}

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = linear(context)?;
    claims.extend(yielding(context)?);
    if context.profile == Profile::Full {
        claims.extend(bilinear(context)?);
    }
    Ok(claims)
}

/// Variance of the first storey's drift at the end of a linear building from rest: the integral of its squared response to
/// an impulse, by Runge-Kutta steps of a tenth and Simpson's rule.
fn exact_variance(building: &ShearBuilding) -> f64 {
    let n = building.n_states();
    let drift = |x: &[f64]| -> Vec<f64> {
        let rows: Vec<[f64; 1]> = x.iter().map(|&value| [value]).collect();
        let mut rates = vec![[0.0]; n];
        building.drift(0.0, &rows, &mut rates);
        rates.into_iter().map(|[rate]| rate).collect()
    };
    let ahead = |x: &[f64], h: f64, k: &[f64]| -> Vec<f64> {
        x.iter().zip(k).map(|(x, k)| x + h * k).collect()
    };
    let mut x = vec![0.0; n];
    building.noise(0.0, &mut x);
    let (n_steps, h) = (10 * SPAN.1, SPAN.0 / (10 * SPAN.1) as f64);
    let mut integral = 0.0;
    for step in 0..=n_steps {
        let weight = match step {
            0 => 1.0,
            _ if step == n_steps => 1.0,
            _ if step % 2 == 1 => 4.0,
            _ => 2.0,
        };
        integral += weight * h / 3.0 * x[0] * x[0];
        let k_1 = drift(&x);
        let k_2 = drift(&ahead(&x, 0.5 * h, &k_1));
        let k_3 = drift(&ahead(&x, 0.5 * h, &k_2));
        let k_4 = drift(&ahead(&x, h, &k_3));
        for (k, weight) in [(k_1, 1.0), (k_2, 2.0), (k_3, 2.0), (k_4, 1.0)] {
            x = ahead(&x, weight * h / 6.0, &k);
        }
    }
    integral
}

/// The linear building at 1e-3, 1e-6 and 1e-9.
fn linear(context: &Context<'_>) -> CaseResult {
    let building = building(Some(Hysteresis::None))?;
    let deviation = exact_variance(&building).sqrt();
    let paths = guided(&building)?;
    let mut claims = Vec::new();
    for (z, name) in [(3.3, "1e-3"), (4.9, "1e-6"), (6.1, "1e-9")] {
        context.progress(&format!("linear building, {name}"));
        let found = paths.exceedance(z * deviation, Tails::Both, &CONFIG)?;
        let bias = "1,000 steps: (omega dt)^2/12 of the variance, 7e-4 in the first mode, times z^2/2 = 19";
        let id = format!("linear/exceedance/p-{name}/t10");
        let exact = 2.0 * normal_probability(-z);
        claims.push(against(context, (&id, "P(|u_1| > T)"), &found, exact, (1.5e-2, bias))?);
    }
    Ok(claims)
}

/// The building of the scene: two thresholds and two times from one set of paths, against crude Monte Carlo, and rare passages.
fn yielding(context: &Context<'_>) -> CaseResult {
    let building = building(None)?;
    let paths = guided(&building)?;
    let responses = &[response(&building)][..];
    let question =
        PassageQuestion { responses, thresholds: &FREQUENT, n_steps: &[SPAN.1 / 2, SPAN.1] };
    context.progress("crude Monte Carlo");
    let n_free = if context.profile == Profile::Full { N_FREE_FULL } else { N_FREE };
    let free = free_passages(&building, SPAN, &question, (n_free, 7))?;
    context.progress("guided paths");
    let found = paths.first_passages(&question, &CONFIG)?;
    let mut claims = Vec::new();
    for ((row, free), t) in found.into_iter().zip(free).zip([5, 10]) {
        for ((found, free), threshold) in row.into_iter().zip(free).zip(FREQUENT) {
            let id = format!("yielding/first-passage/threshold-{threshold}/t{t}");
            let quantity = format!("P(max |u_1| > {threshold})");
            let bias = (0.0, SAME_STEPS);
            claims.push(against(context, (&id, &quantity), &found?, estimated(&free), bias)?);
        }
    }
    claims.extend(rare(context, &paths, &building)?);
    Ok(claims)
}

/// Passages of probability 1e-2 and 1e-3, and the number of free paths that judge them.
const FREQUENT: [f64; 2] = [0.018, 0.02];
const N_FREE: u64 = 20_000;
/// The same with `--full`.
const N_FREE_FULL: u64 = 200_000;
const SAME_STEPS: &str = "none: the same steps and the same rule between them";
/// The thresholds of the scene.
const RARE: [f64; 2] = [0.024, 0.029];

/// The standard errors of the passages of the scene, and their bits on one, two and eight threads.
fn rare(context: &Context<'_>, paths: &GuidedPaths<'_>, building: &ShearBuilding) -> CaseResult {
    let responses = &[response(building)][..];
    let question = PassageQuestion { responses, thresholds: &RARE, n_steps: &[SPAN.1] };
    let mut claims = Vec::new();
    let of = |config: &GuidedConfig| -> CaseResult<Vec<GuidedEstimate>> {
        let row = paths.first_passages(&question, config)?.into_iter().flatten();
        Ok(row.collect::<Result<_, _>>()?)
    };
    for (found, threshold) in of(&RARE_CONFIG)?.iter().zip(RARE) {
        let error = found.estimate.standard_error().unwrap_or(f64::NAN);
        let part = error / found.estimate.value;
        let id = format!("yielding/standard-error/threshold-{threshold}/t10");
        let quantity = format!("standard error over P(max |u_1| > {threshold})");
        let claim = context.subject(&id, &quantity, RARE_METHOD).bounded(part, 0.08);
        claims.push(claim.because("statistics: the deviation of a path is a few times its mean"));
    }
    let few = GuidedConfig { n_paths: 2_000, n_pilots: 200, ..CONFIG };
    let question = PassageQuestion { thresholds: &FREQUENT, ..question };
    let bits = || -> CaseResult<Vec<u64>> {
        let row = paths.first_passages(&question, &few)?.into_iter().flatten();
        let found = row.collect::<Result<Vec<_>, _>>()?;
        Ok(found.iter().map(|found| found.estimate.value.to_bits()).collect())
    };
    let reason =
        "a path is a function of seed and realisation, and blocks of 512 paths are summed in order";
    claims.extend(super::over_threads(context, "ten-storeys", reason, bits)?);
    Ok(claims)
}

/// Bilinear storeys against crude Monte Carlo.
fn bilinear(context: &Context<'_>) -> CaseResult {
    let hysteresis = Hysteresis::Bilinear { post_yield_ratio: 0.3, yield_drift: 0.005 };
    let building = building(Some(hysteresis))?;
    let paths = guided(&building)?;
    let responses = &[response(&building)][..];
    let thresholds = &FREQUENT[..1];
    let question = PassageQuestion { responses, thresholds, n_steps: &[SPAN.1] };
    context.progress("bilinear storeys");
    let free = free_passages(&building, SPAN, &question, (N_FREE_FULL, 7))?[0][0];
    let found = paths.first_passages(&question, &CONFIG)?.remove(0).remove(0)?;
    let id = format!("bilinear/first-passage/threshold-{}/t10", FREQUENT[0]);
    let quantity = format!("P(max |u_1| > {})", FREQUENT[0]);
    Ok(vec![against(context, (&id, &quantity), &found, estimated(&free), (0.0, SAME_STEPS))?])
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
