//! Bonds that wear out: the exact step of their law against an integration that shares nothing with it.

use peridyn_sde::BondLaw;
use peridyn_sde::law::Memory;
use reference_problems::peridyn::memory::{Wear, stepped};
use serde_json::Value;

use super::memory_body;
use super::rest::{number, numbers};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/memory",
    title: "Damage with memory: ramp, hold, unload, and a sine, for several exponents; a block and a bar; a bond that softens",
    source: "section 2.1 of the note, eq 5 as d alpha/dt = -lambda exp(k s) alpha^n (1 - alpha)^m, by a Runge-Kutta method of fourth order; alpha_ramp.json",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// `k`.
const SENSITIVITY: f64 = 800.0;
/// `lambda`, so low that with `n = 1/2` something is left at the end.
const RATE: f64 = 0.3;
/// `alpha(0)`.
const START: f64 = 0.9;

const EXPONENTS: [(&str, (f64, f64)); 4] = [
    ("n-1-m-1", (1.0, 1.0)),
    ("n-2-m-2", (2.0, 2.0)),
    ("n-0.5-m-1", (0.5, 1.0)),
    ("n-3-m-0.5", (3.0, 0.5)),
];

/// Up to 2e-3 in a unit of time, held for one, down in one.
fn broken_line(t: f64) -> f64 {
    2e-3 * t.min(1.0) - 2e-3 * (t - 2.0).clamp(0.0, 1.0)
}

fn wear((n, m): (f64, f64)) -> Wear {
    Wear { sensitivity: SENSITIVITY, rate: RATE, n, m, start: START }
}

fn sine(t: f64) -> f64 {
    2e-3 * (1.3 * t).sin()
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (mut own, mut exact, mut order) = (Worst::default(), Worst::default(), Worst::default());
    for (id, exponents) in EXPONENTS {
        let law = wear(exponents).law()?;
        see_lines(id, &law, exponents, [&mut own, &mut exact]);
        order.take(order_of_curve(&law, exponents) - 2.0, id);
    }
    let method = format!(
        "four pairs of exponents n and m, k = {SENSITIVITY}, lambda = {RATE}, alpha(0) = {START}"
    );
    let lines = |worst: &Worst| Lines { context, id: "", method: worst.method(&method) };
    let mut claims = vec![
        lines(&own).bounded(
            ("integration", "alpha by 30,000 less that by 15,000 steps of Runge-Kutta in a unit of time", ""),
            own.value(),
            1e-13,
            "roundoff: what is compared with is known that well: fourth order leaves 1e-17, 90,000 steps of 1e-16 some 1e-14",
        ),
        lines(&exact).bounded(
            ("ramp-hold-unload", "largest error of alpha after ramp, hold and unloading, one step each", ""),
            exact.value(),
            1e-13,
            "roundoff: the step is exact on straight lines of strain; that of the reference, 1e-14, and the table of the law",
        ),
        lines(&order).bounded(
            ("sine/order", "order of the error under a sine of strain, between 40 and 80 steps, less two", ""),
            order.value(),
            2e-3,
            "two: a step follows the chord of the strain; the next order at 40 steps",
        ),
    ];
    claims.push(of_reference(context)?);
    claims.extend(of_end(context)?);
    claims.extend(memory_body::block(context)?);
    claims.push(memory_body::bar(context)?);
    claims.push(memory_body::softening(context)?);
    Ok(claims)
}

/// Ends of the ramp, the hold and the unloading, in one step each.
fn see_lines(id: &str, law: &Memory, exponents: (f64, f64), [own, exact]: [&mut Worst; 2]) {
    for steps in [1, 2, 3] {
        let (until, place) = (f64::from(steps), format!("{id}, t = {steps}"));
        let fine = wear(exponents).integrated(broken_line, until, 30_000 * steps);
        let coarse = wear(exponents).integrated(broken_line, until, 15_000 * steps);
        own.take(fine - coarse, &place);
        exact.take(stepped(law, broken_line, until, steps) - fine, &place);
    }
}

fn order_of_curve(law: &Memory, exponents: (f64, f64)) -> f64 {
    let exact = wear(exponents).integrated(sine, 2.0, 40_000);
    let error = |steps: u32| (stepped(law, sine, 2.0, steps) - exact).abs();
    (error(40) / error(80)).log2()
}

/// `d alpha/dt = -exp(k s) alpha (1 - alpha)` under a ramp, from 0.99.
fn of_reference(context: &Context<'_>) -> Result<Claim, CaseError> {
    let text = include_str!("../../../reference/derived/peridyn/alpha_ramp.json");
    let reference: Value = serde_json::from_str(text)?;
    let law =
        Memory::new(number(&reference["k"])?, 1.0, (1.0, 1.0), number(&reference["alpha0"])?)?;
    let (times, expected) = (numbers(&reference["t"])?, numbers(&reference["alpha"])?);
    let (mut state, mut last, mut worst) = (0.0, 0.0, 0.0_f64);
    for (t, expected) in times.into_iter().zip(expected) {
        if t > last {
            law.advance(1.0, 1e-3 * last, 1e-3 * t, t - last, &mut state);
        }
        worst = worst.max((1.0 - law.damage(1.0, &state) - expected).abs());
        last = t;
    }
    let method = "n = m = 1, k = 2e4, alpha(0) = 0.99, seven steps";
    let lines = Lines { context, id: "ramp", method: method.into() };
    Ok(lines.bounded(
        ("error", "largest error of alpha against the closed form", ""),
        worst,
        2e-15,
        "roundoff: exact on straight lines of strain, seven sums",
    ))
}

/// At rest with `n = 1/2`, `m = 1` the exposure until nothing is left is `2 artanh sqrt(alpha(0))`, 5.986 from 0.99.
fn of_end(context: &Context<'_>) -> Result<[Claim; 2], CaseError> {
    let law = Memory::new(0.0, 1.0, (0.5, 1.0), 0.99)?;
    let end = 2.0 * 0.99_f64.sqrt().atanh();
    let lines =
        Lines { context, id: "end", method: "n = 0.5, m = 1, k = 0, alpha(0) = 0.99".into() };
    // Near its end alpha = (left/2)^2.
    let before = law.left(end - 1e-3);
    Ok([
        lines.relative(
            ("before", "alpha 1e-3 before the exposure at which nothing is left", ""),
            before,
            (0.5e-3_f64).tanh().powi(2),
            1e-11,
            "closed form tanh^2(left/2); roundoff of the exposure, 1e-15 of 1e-3, doubled, and the table",
        ),
        lines.bounded(
            ("after", "alpha 1e-3 after it", ""),
            law.left(end + 1e-3),
            0.0,
            "with n below one a bond is gone after a finite exposure",
        ),
    ])
}
