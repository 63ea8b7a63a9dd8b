//! Rare events: importance sampling and subset simulation.

use result_figures::ErrorKind;
use sde_integrators::{
    Additive, DrivenPath, Error, EulerMaruyama, Noise, Sde, StrangOscillator, SubsetConfig,
    design_point, importance_sampling, subset_simulation,
};

use super::{Oscillator, against_exact, upper_tail};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/ensembles/rare-events",
    title: "Importance sampling and subset simulation against exact values",
    source: "Caughey & Stumpf 1961; reflection principle",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const OSCILLATOR: Oscillator = Oscillator { omega: 2.0, xi: 0.05, intensity: 1.0 };
const TIME: f64 = 6.0;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = oscillator(context, OSCILLATOR)?;
    claims.push(mutated(context)?);
    claims.push(first_passage(context)?);
    Ok(claims)
}

/// `P(q(T) > b)` from rest at 4.5 deviations, 3.4e-6: a linear response, so that the design point is exact.
fn oscillator(context: &Context<'_>, system: Oscillator) -> Result<Vec<Claim>, CaseError> {
    let n_steps = 120;
    let path = DrivenPath {
        system: &system,
        integrator: &StrangOscillator,
        start: [0.0; 2],
        dt: TIME / n_steps as f64,
        n_steps,
    };
    let n_normals = path.n_normals::<1>();
    let response =
        |normals: &[f64]| -> Result<f64, Error> { Ok(path.run::<1>(normals, |_, _, _| ())?[0]) };
    let threshold = 4.5 * OSCILLATOR.variance(TIME).sqrt();
    let exact = upper_tail(4.5);
    let point = design_point(&response, n_normals, threshold)?;
    let sampled = importance_sampling(&response, threshold, &point, &Noise::new(3), 20_000)?;
    // Number of full runs that shows a bias of 10 % per run at five standard errors.
    let n_runs = if context.profile == Profile::Full { 600 } else { 24 };
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs };
    let subset = subset_simulation(&response, n_normals, threshold, &Noise::new(4), &config)?;
    Ok(vec![
        Claim::within(
            context.subject(
                "design-point",
                "reliability index of q(6)",
                "",
                "FORM, 120 Strang steps",
            ),
            ErrorKind::Relative,
            (point.reliability_index, 4.5),
            1e-4,
            "the variance of 120 Strang steps errs by a small part of (omega h)^2 = 1e-2",
        ),
        against_exact(
            context,
            ("importance", "P(q(6) > 4.5 deviations)", "design point, 20,000 samples"),
            &sampled,
            exact,
            (0.03, "beta^2 times the error of the deviation, below 1e-3 each way"),
        )?,
        against_exact(
            context,
            (
                "subset",
                "P(q(6) > 4.5 deviations)",
                &format!("subset simulation, {n_runs} runs of 1,000 per level"),
            ),
            &subset,
            exact,
            (
                0.06,
                "the same 3 %, and the bias of a run: 600 runs are off by -1.0 %, standard error 1.7 %",
            ),
        )?,
    ])
}

/// One per cent more noise moves the probability by `beta^2` per cent, 20 %, and the index by one: both estimators must
/// see it.
fn mutated(context: &Context<'_>) -> Result<Claim, CaseError> {
    let changed = Oscillator { intensity: 1.01 * OSCILLATOR.intensity, ..OSCILLATOR };
    let claims = oscillator(context, changed)?;
    let n_failed = claims[..2].iter().filter(|claim| !claim.passed).count();
    Ok(Claim::within(
        context.subject(
            "mutated/noise-1-percent-up",
            "claims that fail, of the index and the importance sample",
            "",
            "noise 1 % too strong",
        ),
        ErrorKind::Absolute,
        (n_failed as f64, 2.0),
        0.0,
        "both hold with the right constant",
    ))
}

/// `dX = dB`.
struct BrownianMotion;

impl Sde<1, 1> for BrownianMotion {
    type Noise = Additive;

    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

/// `P(max W > 4)` over the unit of time, `2 Phi(-4) = 6.3e-5`. The maximum between steps is a function of two more
/// normals per step, `-ln U = (z_1^2 + z_2^2)/2`, so that the answer is exact with 16 steps.
fn first_passage(context: &Context<'_>) -> Result<Claim, CaseError> {
    let n_steps = 16;
    let dt = 1.0 / n_steps as f64;
    let path = DrivenPath {
        system: &BrownianMotion,
        integrator: &EulerMaruyama,
        start: [0.0],
        dt,
        n_steps,
    };
    let n_driving = path.n_normals::<1>();
    let response = |normals: &[f64]| -> Result<f64, Error> {
        let (driving, between) = normals.split_at(n_driving);
        let (mut largest, mut pairs) = (0.0_f64, between.chunks_exact(2));
        path.run::<1>(driving, |_, &[x_0], &[x_1]| {
            let square: f64 = pairs.next().into_iter().flatten().map(|z| z * z).sum();
            let spread = ((x_1 - x_0).powi(2) + dt * square).sqrt();
            largest = largest.max(0.5 * (x_0 + x_1 + spread));
        })?;
        Ok(largest)
    };
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 24 };
    let estimate = subset_simulation(&response, 3 * n_steps, 4.0, &Noise::new(5), &config)?;
    against_exact(
        context,
        ("subset-passage", "P(max W > 4)", "subset simulation, 24 runs of 1,000 per level"),
        &estimate,
        2.0 * upper_tail(4.0),
        (0.1, "the bias of a run: the square of its coefficient of variation, 0.3"),
    )
}
