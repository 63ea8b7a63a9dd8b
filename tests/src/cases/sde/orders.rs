//! Strong, weak and noise-free orders of every method of the tables.

use reference_problems::order;
use reference_problems::sde::linear::StepMap;
use reference_problems::sde::methods::{Method, additive, diagonal, follow, second_order};
use reference_problems::sde::orders::{Errors, Level, Outcome, Study, measure};
use reference_problems::sde::problems::{
    Ageing, Duffing, Geometric, HyperbolicSine, Oscillator, Populations, Sine,
};
use reference_problems::sde::quadrature::{expectation, gauss_hermite};
use sde_integrators::{DiagonalNoise, Increment, Shark, Sra3, Sriw1, StateSpace};

use crate::cases::prelude::*;

pub(crate) const ADDITIVE: Case = Case {
    id: "sde-integrators/order-additive",
    title: "orders for additive noise, on a drift nonlinear in the noisy variable and on noise that changes in time",
    source: "Rößler 2010; Foster, dos Reis and Strange 2024; SciML prob_sde_additive; fine reference by SRA3",
    cost: Profile::Quick,
    run: Together(run_additive),
};

pub(crate) const DIAGONAL: Case = Case {
    id: "sde-integrators/order-diagonal",
    title: "orders for diagonal noise: geometric Brownian motion without sampling, hyperbolic sine, two populations",
    source: "closed solutions of Kloeden and Platen 1992, section 4.4; Rößler 2010",
    cost: Profile::Default,
    run: Together(run_diagonal),
};

pub(crate) const SECOND_ORDER: Case = Case {
    id: "sde-integrators/order-oscillator",
    title: "orders on Duffing's oscillator with additive noise on the velocity",
    source: "fine reference by ShARK",
    cost: Profile::Quick,
    run: Together(run_second_order),
};

/// How closely an order must be met.
#[derive(Debug, Clone, Copy)]
struct Tolerance {
    /// On the slope.
    slope: f64,
    /// Where no slope can be fitted: on the error at the finest level, besides 4 standard errors.
    accuracy: f64,
    /// Why.
    reason: &'static str,
}

/// The claim on an order: a fitted slope, or the accuracy where the errors are below their noise.
fn order_claim(
    context: &Context<'_>,
    id: &str,
    what: &str,
    method: &str,
    errors: &Errors,
    expected: f64,
    tolerance: Tolerance,
) -> Claim {
    let words = |level: &Level| {
        let Measured { value, standard_error } = level.error;
        format!(
            "{:.3e} (s.e. {:.0e}) at h = {:.3e}",
            value,
            standard_error.unwrap_or(0.0),
            level.dt
        )
    };
    let ends = match (errors.levels.first(), errors.levels.last()) {
        (Some(first), Some(last)) => format!("{method}: {} to {}", words(first), words(last)),
        _ => method.to_owned(),
    };
    if let Some(order) = errors.order {
        return context
            .subject(id, what, &ends)
            .order(order, expected)
            .within(tolerance.slope)
            .because(tolerance.reason);
    }
    let reason =
        "fewer than four levels of one sign are above their noise: accuracy instead of a slope";
    context
        .subject(id, format!("error, for {what}"), &ends)
        .absolute(errors.levels.last().map_or(Measured::exact(f64::NAN), |level| level.error), 0.0)
        .monte_carlo(tolerance.accuracy)
        .because(reason)
}

const STRONG: Tolerance = Tolerance {
    slope: 0.1,
    accuracy: 1e-3,
    reason: "the next term of the error at the coarsest level bends the line by less; slope by least squares, its error by jackknife and scatter",
};

const WEAK: Tolerance = Tolerance {
    slope: 0.3,
    accuracy: 1e-3,
    reason: "coarse steps, where the error is above its noise: the next term bends the line",
};

const NOISE_FREE: f64 = 0.12;
/// Steps of the reference without noise: 64 times the finest level, so that its error is below 1e-3 of it.
const FINE: usize = 1 << 15;

/// The claims of a table on one problem, strong and weak.
fn order_claims<S, const D: usize, const M: usize>(
    context: &Context<'_>,
    problem: &str,
    methods: &[Method<S, D, M>],
    strong: Option<&[Outcome]>,
    weak: Option<(&[Outcome], &[&str])>,
) -> Vec<Claim> {
    let mut claims = Vec::new();
    for (k, method) in methods.iter().enumerate() {
        if let Some(outcomes) = strong {
            let id = format!("{problem}/{}/strong", method.id);
            let (errors, order) = (&outcomes[k].strong, method.orders.strong);
            claims.push(order_claim(
                context,
                &id,
                "strong order",
                method.name,
                errors,
                order,
                STRONG,
            ));
        }
        if let Some((outcomes, names)) = weak {
            for (errors, name) in outcomes[k].weak.iter().zip(names) {
                let id = format!("{problem}/{}/weak-{name}", method.id);
                let what = format!("weak order of the {}", name.replace('-', " "));
                let order = method.orders.weak;
                claims.push(order_claim(context, &id, &what, method.name, errors, order, WEAK));
            }
        }
    }
    claims
}

/// The order without noise: a path whose increments are zero, against SRA3 or its like at 64 times the steps.
fn noise_free_claims<S, const D: usize, const M: usize>(
    context: &Context<'_>,
    problem: &str,
    (system, start, end): (&S, [f64; D], f64),
    methods: &[Method<S, D, M>],
    exact: [f64; D],
) -> CaseResult {
    let mut claims = Vec::new();
    for method in methods {
        let mut levels = Vec::new();
        for n in [32_usize, 64, 128, 256, 512] {
            let dt = end / n as f64;
            let x = (method.run)(system, start, dt, &vec![Increment::ZERO; n])?;
            let distance = x.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            levels.push((dt, distance));
        }
        let id = format!("{problem}/{}/noise-free", method.id);
        let reason = "the next term of the error at h = 1/32";
        let subject = context.subject(&id, "order without noise", method.name);
        let compared = subject.order(order::fit(&levels)?, method.orders.noise_free);
        claims.push(compared.within(NOISE_FREE).because(reason));
    }
    Ok(claims)
}

fn paths(context: &Context<'_>, quick: u64) -> u64 {
    match context.profile {
        Profile::Quick | Profile::Default => quick,
        Profile::Full => 16 * quick,
    }
}

fn run_additive(context: &Context<'_>) -> CaseResult {
    let methods = additive::<Sine, 1, 1>();
    let start = [1.0];
    let reference =
        |dt: f64, increments: &[Increment<1>]| Ok(follow(&Sine, &Sra3, start, dt, increments)?);
    context.progress("sine: strong orders");
    let study = Study {
        n_paths: paths(context, 4096),
        seed: 11,
        end: 1.0,
        coarsest: 8,
        n_levels: 5,
        refinements: 4,
    };
    let strong = measure(&study, (&Sine, start), &methods, &reference, &[])?;
    context.progress("sine: weak orders");
    let study =
        Study { n_paths: paths(context, 16_384), seed: 12, coarsest: 4, refinements: 4, ..study };
    let names = ["mean", "second-moment"];
    let weak = measure(&study, (&Sine, start), &methods, &reference, &[|x| x[0], |x| x[0] * x[0]])?;
    let mut claims = order_claims(
        context,
        "sine",
        &methods,
        Some(&strong.methods),
        Some((&weak.methods, &names)),
    );
    let exact = follow(&Sine, &Sra3, start, 1.0 / FINE as f64, &vec![Increment::ZERO; FINE])?;
    claims.extend(noise_free_claims(context, "sine", (&Sine, start, 1.0), &methods, exact)?);
    claims.extend(ageing_claims(context)?);
    Ok(claims)
}

/// Noise that changes in time: methods of strong order 1.5 must integrate it to that order. On this linear problem they
/// reach 2, and so does Heun, which is why it alone is no test of order 1.5.
fn ageing_claims(context: &Context<'_>) -> CaseResult {
    context.progress("ageing: noise that changes in time");
    let methods: Vec<_> = additive::<Ageing, 1, 1>()
        .into_iter()
        .filter(|method| ["heun", "sra3", "shark"].contains(&method.id))
        .map(|mut method| {
            method.orders.strong = 2.0;
            method
        })
        .collect();
    let start = 1.0;
    let exact = |_: f64, increments: &[Increment<1>]| {
        Ok([Ageing::exact(start, 1.0, increments.iter().map(|dw| dw.brownian[0]).sum())])
    };
    let study = Study {
        n_paths: paths(context, 4096),
        seed: 13,
        end: 1.0,
        coarsest: 8,
        n_levels: 5,
        refinements: 0,
    };
    let outcomes = measure(&study, (&Ageing, [start]), &methods, &exact, &[])?;
    Ok(order_claims(context, "ageing", &methods, Some(&outcomes.methods), None))
}

fn run_diagonal(context: &Context<'_>) -> CaseResult {
    let mut claims = geometric_claims(context)?;
    context.progress("hyperbolic sine");
    let system = DiagonalNoise(HyperbolicSine);
    let methods = diagonal::<HyperbolicSine, 1>();
    let end = 0.5;
    let exact = |_: f64, increments: &[Increment<1>]| {
        Ok([(end + increments.iter().map(|dw| dw.brownian[0]).sum::<f64>()).sinh()])
    };
    let study = Study {
        n_paths: paths(context, 8192),
        seed: 21,
        end,
        coarsest: 64,
        n_levels: 5,
        refinements: 0,
    };
    let outcomes = measure(&study, (&system, [0.0]), &methods, &exact, &[])?;
    claims.extend(order_claims(context, "sinh", &methods, Some(&outcomes.methods), None));
    let coupled = diagonal::<Populations, 2>();
    context.progress("two populations");
    let system = DiagonalNoise(Populations { intensity: [0.9, 0.7] });
    let start = [1.2, 0.8];
    let reference =
        |dt: f64, increments: &[Increment<2>]| Ok(follow(&system, &Sriw1, start, dt, increments)?);
    let study = Study {
        n_paths: paths(context, 2048),
        seed: 22,
        end: 1.0,
        coarsest: 32,
        n_levels: 5,
        refinements: 3,
    };
    let outcomes = measure(&study, (&system, start), &coupled, &reference, &[])?;
    claims.extend(order_claims(context, "populations", &coupled, Some(&outcomes.methods), None));
    // Without noise the terms that are left of it at zero increments, such as b b' h/2, must vanish too.
    let system = DiagonalNoise(Populations { intensity: [0.0; 2] });
    let exact = follow(&system, &Sriw1, start, 1.0 / FINE as f64, &vec![Increment::ZERO; FINE])?;
    claims.extend(noise_free_claims(
        context,
        "populations",
        (&system, start, 1.0),
        &coupled,
        exact,
    )?);
    Ok(claims)
}

/// Geometric Brownian motion: the moments of a step give every error exactly, by powers of one-step expectations.
fn geometric_claims(context: &Context<'_>) -> CaseResult {
    context.progress("geometric Brownian motion, by quadrature");
    let geometric = Geometric { drift: 0.5, intensity: 0.6 };
    let system = DiagonalNoise(geometric);
    let rule = gauss_hermite(16);
    let mut claims = Vec::new();
    for method in diagonal::<Geometric, 1>() {
        let (mut strong, mut mean, mut square) = (Vec::new(), Vec::new(), Vec::new());
        for n in [32_i32, 64, 128, 256, 512] {
            let dt = 1.0 / f64::from(n);
            let factor = |dw: &Increment<1>| -> CaseResult<f64> {
                Ok((method.run)(&system, [1.0], dt, std::slice::from_ref(dw))?[0])
            };
            let exact = |dw: &Increment<1>| geometric.factor(dt, dw.brownian[0]);
            let first = expectation(dt, &rule, factor)?;
            let second = expectation(dt, &rule, |dw| Ok::<_, CaseError>(factor(dw)?.powi(2)))?;
            let cross = expectation(dt, &rule, |dw| Ok::<_, CaseError>(factor(dw)? * exact(dw)))?;
            let (growth, square_growth) = (0.5_f64, 1.36_f64);
            let distance = second.powi(n) - 2.0 * cross.powi(n) + square_growth.exp();
            strong.push((dt, distance.max(0.0).sqrt()));
            mean.push((dt, first.powi(n) - growth.exp()));
            square.push((dt, second.powi(n) - square_growth.exp()));
        }
        let rows = [
            ("strong", "strong order", method.orders.strong, strong, 0.1),
            ("weak-mean", "weak order of the mean", method.orders.weak, mean, 0.1),
            (
                "weak-second-moment",
                "weak order of the second moment",
                method.orders.weak,
                square,
                0.1,
            ),
        ];
        for (name, what, expected, levels, tolerance) in rows {
            // E x of the trapezoidal rule is that of the rule without noise.
            let expected = match (method.id, name) {
                ("trapezoidal", "weak-mean") => 2.0,
                _ => expected,
            };
            let reason = "no sampling: what is left is the next term of the error";
            let subject =
                context.subject(format!("geometric/{}/{name}", method.id), what, method.name);
            let compared = subject.order(order::fit(&levels)?, expected);
            claims.push(compared.within(tolerance).because(reason));
        }
    }
    Ok(claims)
}

fn run_second_order(context: &Context<'_>) -> CaseResult {
    let system = StateSpace(Duffing);
    let methods = second_order::<Duffing>();
    let start = [1.0, 0.0];
    let reference =
        |dt: f64, increments: &[Increment<1>]| Ok(follow(&system, &Shark, start, dt, increments)?);
    context.progress("Duffing: strong and weak orders");
    let study = Study {
        n_paths: paths(context, 4096),
        seed: 31,
        end: 2.0,
        coarsest: 16,
        n_levels: 5,
        refinements: 3,
    };
    let observables: [fn(&[f64; 2]) -> f64; 1] = [|x| x[0] * x[0]];
    let outcomes = measure(&study, (&system, start), &methods, &reference, &observables)?;
    let mut claims = order_claims(
        context,
        "duffing",
        &methods,
        Some(&outcomes.methods),
        Some((&outcomes.methods, &["second-moment-q"])),
    );
    let exact = follow(&system, &Sra3, start, 2.0 / FINE as f64, &vec![Increment::ZERO; FINE])?;
    claims.extend(noise_free_claims(context, "duffing", (&system, start, 2.0), &methods, exact)?);
    claims.extend(linear_claims(context)?);
    Ok(claims)
}

/// `E[q^2]` of a linear oscillator that starts from rest, by the moments of one step: no sampling.
///
/// $$ E q^2 = \frac{s^2}{4 \xi \omega^3} \left(1 - e^{-2 \xi \omega t} \left(1 + \frac{\xi\omega}{\omega_d} \sin 2 \omega_d t +
///    2 \frac{\xi^2\omega^2}{\omega_d^2} \sin^2 \omega_d t\right)\right) $$
///
/// Source: Caughey and Stumpf 1961, Transient response of a dynamic system under random excitation.
fn linear_claims(context: &Context<'_>) -> CaseResult {
    let oscillator = Oscillator { frequency: 2.0, damping_ratio: 0.3, intensity: 0.8 };
    let (end, decay) = (1.5, 0.3 * 2.0);
    let damped = (4.0_f64 - decay * decay).sqrt();
    let ratio = decay / damped;
    let (sin, double) = ((damped * end).sin(), (2.0 * damped * end).sin());
    let transient =
        (-2.0 * decay * end).exp() * (1.0 + ratio * double + 2.0 * (ratio * sin).powi(2));
    let exact = oscillator.velocity_variance() / 4.0 * (1.0 - transient);
    let system = StateSpace(oscillator);
    let mut claims = Vec::new();
    for method in second_order::<Oscillator>() {
        let mut levels = Vec::new();
        for n in [256_u32, 512, 1024, 2048, 4096] {
            let dt = end / f64::from(n);
            let map = StepMap::of(|x: [f64; 2], w, area| {
                let dw = Increment { brownian: [w], space_time_area: [area] };
                Ok::<_, CaseError>((method.run)(&system, x, dt, &[dw])?.to_vec())
            })?;
            let rest = vec![vec![0.0; 2]; 2];
            let p = (0..n).fold(rest, |p, _| map.covariance(&p, dt));
            levels.push((dt, p[0][0] - exact));
        }
        let id = format!("linear/{}/weak-second-moment-q", method.id);
        let reason = "no sampling: what is left is the next term of the error";
        let subject = context.subject(&id, "weak order of E[q^2]", method.name);
        let compared = subject.order(order::fit(&levels)?, method.orders.weak);
        claims.push(compared.within(0.1).because(reason));
    }
    Ok(claims)
}
