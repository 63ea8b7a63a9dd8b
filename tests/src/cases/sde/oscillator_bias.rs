//! The bias of `E[q^2]` of the oscillator with a viscous damper against the step length, by coupled differences.

use figures::{ErrorKind, Measured, Reference};
use fpk_sph::systems::ViscousDamper;
use sde_integrators::{EulerMaruyama, Increment, SemiImplicitEuler, Shark, Sra1, StrangOscillator};
use work_precision::problems::sde::damper::viscous_damper_at_rest;
use work_precision::problems::sde::methods::{Method, follow, method};
use work_precision::problems::sde::orders::{Level, Study, measure};
use work_precision::problems::sde::reference::OscillatorBias;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/oscillator-bias",
    title: "bias of E[q^2] against step length on the oscillator with a viscous damper, T = 10 s from rest",
    source: "Canor and Denoël 2013, eq 26 with a = 1; derived/sde/oscillator_bias.json, 80,000 paths",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const END: f64 = 10.0;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let system = viscous_damper_at_rest()?;
    let none = [f64::NAN; 3];
    let methods: Vec<Method<ViscousDamper, 2, 1>> = vec![
        method("euler-maruyama", "Euler-Maruyama", EulerMaruyama, none),
        method("semi-implicit-euler", "semi-implicit Euler", SemiImplicitEuler, none),
        method("sra1", "SRA1", Sra1, none),
        method("shark", "ShARK", Shark, none),
        method("strang-oscillator", "Strang", StrangOscillator, none),
    ];
    let n_paths = match context.profile {
        Profile::Quick => 2560,
        Profile::Default => 16_000,
        Profile::Full => 80_000,
    };
    let study = Study { n_paths, seed: 51, end: END, coarsest: 128, n_levels: 6, refinements: 0 };
    let start = [0.0; 2];
    let reference = |dt: f64, increments: &[Increment<1>]| {
        Ok(follow(&system, &StrangOscillator, start, dt, increments)?)
    };
    context.progress(&format!("{n_paths} coupled paths"));
    let outcomes = measure(&study, (&system, start), &methods, &reference, &[|x| x[0] * x[0]])?;
    let scale = outcomes.reference[0].value;
    let mut claims = Vec::new();
    let survey = OscillatorBias::read()?;
    for (method, outcome) in methods.iter().zip(&outcomes.methods) {
        let rows = survey.methods.get(method.id).ok_or("a method without reference data")?;
        for (level, &(_, published, error)) in outcome.weak[0].levels.iter().rev().zip(rows) {
            // The reference against itself says nothing.
            if error > 0.0 {
                let named = format!("{}, {n_paths} paths", method.name);
                let expected = Reference::uncertain(published, error);
                claims.push(bias_claim(context, (method.id, &named), level, scale, expected));
            }
        }
    }
    if context.profile > Profile::Quick {
        claims.push(steps_claim(context, &outcomes.methods[4].weak[0].levels, scale));
    }
    Ok(claims)
}

fn bias_claim(
    context: &Context<'_>,
    (id, method): (&str, &str),
    level: &Level,
    scale: f64,
    expected: Reference,
) -> Claim {
    let subject = context.subject(
        &format!("{id}/h-{:.4}", level.dt),
        "relative bias of E[q^2]",
        "",
        &format!("{method}, against Strang at h = 0.0024"),
    );
    let Measured { value, standard_error } = level.error;
    let measured = Measured::sampled(value / scale, standard_error.unwrap_or(0.0) / scale);
    let bias_bound = 0.01 * expected.value.abs();
    let reason =
        "1 % of the bias: its unit, E[q^2] of the reference, is known to 0.5 % in the survey";
    let criterion = Criterion::MonteCarlo { bias_bound, reason };
    Claim::judge(subject, ErrorKind::Absolute, measured, expected, criterion)
}

/// The bias of the splitting is `C h^2`, `C` from the two coarsest levels by their weights; then the steps for 1e-3.
fn steps_claim(context: &Context<'_>, levels: &[Level], scale: f64) -> Claim {
    let (mut numerator, mut weight) = (0.0, 0.0);
    for level in &levels[..2] {
        let square = level.dt * level.dt;
        let error = level.error.standard_error.unwrap_or(f64::NAN) / scale;
        numerator += square * level.error.value.abs() / scale / (error * error);
        weight += (square / error).powi(2);
    }
    let (c, error) = (numerator / weight, weight.powf(-0.5));
    let steps = END * (c / 1e-3).sqrt();
    let subject = context.subject(
        "strang-oscillator/steps-for-1e-3",
        "steps of 10 s for a relative bias of 1e-3",
        "",
        "Strang, bias C h^2 from 128 and 256 steps",
    );
    let measured = Measured::sampled(steps, 0.5 * steps * error / c);
    let reason = "the survey says 150 to 200";
    let criterion = Criterion::MonteCarlo { bias_bound: 25.0, reason };
    Claim::judge(subject, ErrorKind::Absolute, measured, Reference::exact(175.0), criterion)
}
