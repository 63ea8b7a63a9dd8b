//! The bias of `E[q^2]` of the oscillator with a viscous damper against the step length, by coupled differences.

use reference_problems::sde::damper::viscous_damper_at_rest;
use reference_problems::sde::methods::{Method, follow, method};
use reference_problems::sde::orders::{Level, Study, measure};
use reference_problems::sde::reference::OscillatorBias;
use sde_integrators::{EulerMaruyama, Increment, SemiImplicitEuler, Shark, StrangOscillator};
use vibrating_systems::ViscousDamper;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/oscillator-bias",
    title: "bias of E[q^2] against step length on the oscillator with a viscous damper, T = 10 s from rest",
    source: "Canor and Denoël 2013, eq 26 with a = 1; derived/sde/oscillator_bias.json, 80,000 paths",
    cost: Profile::Default,
    run: Together(run),
};

const END: f64 = 10.0;

fn run(context: &Context<'_>) -> CaseResult {
    let system = viscous_damper_at_rest()?;
    let none = [f64::NAN; 3];
    let methods: Vec<Method<ViscousDamper, 2, 1>> = vec![
        method("euler-maruyama", "Euler-Maruyama", EulerMaruyama, none),
        method("semi-implicit-euler", "semi-implicit Euler", SemiImplicitEuler, none),
        method("shark", "ShARK", Shark, none),
        method("strang-oscillator", "Strang", StrangOscillator, none),
    ];
    let n_paths = match context.profile {
        Profile::Quick | Profile::Default => 4_000,
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
            let named = format!("{}, {n_paths} paths", method.name);
            let expected = Reference::uncertain(published, error);
            claims.extend(bias_claim(context, (method.id, &named), level, scale, expected));
        }
    }
    let strang = &outcomes.methods[3].weak[0].levels[0];
    claims.push(strang_claim(context, n_paths, strang, scale));
    Ok(claims)
}

/// A bias counts as resolved, and is claimed, where what is admitted is at most this part of it.
const RESOLVED: f64 = 2.0 / 3.0;

/// The claim of a level, where the samples of both sides resolve its bias. Which levels these are depends on standard errors
/// and on the survey alone, not on what was measured.
fn bias_claim(
    context: &Context<'_>,
    (id, method): (&str, &str),
    level: &Level,
    scale: f64,
    expected: Reference,
) -> Option<Claim> {
    let Measured { value, standard_error } = level.error;
    let bias_bound = 0.01 * expected.value.abs();
    let reason =
        "1 % of the bias: its unit, E[q^2] of the reference, is known to 0.5 % in the survey";
    let claim = context
        .subject(
            format!("{id}/h-{:.4}", level.dt),
            "relative bias of E[q^2]",
            format!("{method}, against Strang at h = 0.0024"),
        )
        .absolute(Measured::sampled(value / scale, standard_error.unwrap_or(0.0) / scale), expected)
        .monte_carlo(bias_bound)
        .because(reason);
    let admitted = claim.tolerance.unwrap_or(f64::INFINITY);
    // The reference against itself has no error and says nothing.
    let is_reference = expected.error.is_some_and(|error| error <= 0.0);
    (!is_reference && admitted <= RESOLVED * expected.value.abs()).then_some(claim)
}

/// Strang's splitting at the longest step. The survey's bias of -1.6e-3 is below the standard errors: what is claimed is the
/// accuracy of the moment itself.
fn strang_claim(context: &Context<'_>, n_paths: u64, level: &Level, scale: f64) -> Claim {
    let Measured { value, standard_error } = level.error;
    let error = standard_error.unwrap_or(f64::NAN) / scale;
    let reason = "the survey's bias, 1.55e-3";
    context
        .subject(
            format!("strang-oscillator/second-moment-q/h-{:.4}", level.dt),
            "E[q^2] over that at h = 0.0024",
            format!("Strang, {n_paths} coupled paths"),
        )
        .relative(Measured::sampled(1.0 + value / scale, error), 1.0)
        .monte_carlo(1.55e-3)
        .because(reason)
}
