//! Rare events and smaller errors: importance sampling, subset simulation, control variates, antithetic paths.

use result_figures::ErrorKind;
use sde_integrators::{
    Additive, DrivenPath, Ensemble, EnsembleConfig, Error, EulerMaruyama, Noise, Observable,
    Sampling, Sde, SimdLevel, StrangOscillator, Study, SubsetConfig, design_point,
    importance_sampling, subset_simulation,
};

use super::{Oscillator, against_exact, upper_tail};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/ensembles/rare-events",
    title: "Importance sampling, subset simulation, control variates and antithetic paths against exact values",
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
    claims.extend(smaller_errors(context)?);
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

fn ensemble(sampling: Sampling, observables: &[Observable<'_, 2>]) -> Result<Ensemble, CaseError> {
    let config = EnsembleConfig { seed: 8, n_paths: 20_000, dt: 0.05, times: vec![TIME] };
    let study = Study {
        name: "smaller errors",
        system: &OSCILLATOR,
        integrator: &StrangOscillator,
        law: &[0.3, 0.0],
        config: &config,
        observables,
        sampling,
        level: SimdLevel::best(),
    };
    Ok(study.run::<1>()?.ensemble()?)
}

/// `E[exp(a q)]`: the mean plain, with `q` as control, and by antithetic paths; all against the lognormal mean.
fn smaller_errors(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    const A: f64 = 0.3;
    let Oscillator { omega, xi, .. } = OSCILLATOR;
    let damped = omega * (1.0 - xi * xi).sqrt();
    let mean = |t: f64| {
        0.3 * (-xi * omega * t).exp()
            * ((damped * t).cos() + xi * omega / damped * (damped * t).sin())
    };
    let value = |_: f64, x: &[f64; 2]| (A * x[0]).exp();
    let plain = [Observable::Mean(&value)];
    let controlled =
        [Observable::Controlled { value: &value, control: &|_, x| x[0], expected: &mean }];
    let exact = (A * mean(TIME) + 0.5 * A * A * OSCILLATOR.variance(TIME)).exp();
    let mut claims = Vec::new();
    let mut errors = Vec::new();
    for (name, sampling, observables) in [
        ("plain", Sampling::Independent, &plain),
        ("control-variate", Sampling::Independent, &controlled),
        ("antithetic", Sampling::Antithetic, &plain),
    ] {
        let estimate = ensemble(sampling, observables)?.estimates[0][0];
        errors.push(estimate.standard_error().ok_or("no standard error")?);
        claims.push(against_exact(
            context,
            (name, "E[exp(0.3 q)]", "Strang, h = 0.05, 20,000 paths"),
            &estimate,
            exact,
            (3e-4, "the mean and the variance err by (omega h)^2/24 and less, 4e-4 of them"),
        )?);
    }
    // With s the deviation of a q: its correlation with exp(a q) has the square s^2/(exp s^2 - 1), and that of exp(a q) with
    // exp(-a q) about the mean is -exp(-s^2).
    let square = A * A * OSCILLATOR.variance(TIME);
    let controlled = (1.0 - square / square.exp_m1()).powf(-0.5);
    let antithetic = (-(-square).exp_m1()).powf(-0.5);
    for (name, k, exact) in
        [("control-variate-gain", 1, controlled), ("antithetic-gain", 2, antithetic)]
    {
        claims.push(Claim::within(
            context.subject(
                name,
                "standard error, plain over this",
                "",
                "20,000 paths, against the closed form for a normal response",
            ),
            ErrorKind::Relative,
            (errors[0] / errors[k], exact),
            0.05,
            "statistics: the ratio of two deviations of 20,000 values, 1 % each where tails are normal",
        ));
    }
    Ok(claims)
}
