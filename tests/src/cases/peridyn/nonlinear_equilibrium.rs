//! The invariant measure `exp(-V/kT)` of bonds whose tension is not linear, sampled and by quadrature.

use peridyn_sde::{CorrelatedMobility, Dynamics, Mobility, Scheme};
use random_fields::{Correlation, CorrelationFunction};
use reference_problems::peridyn::nonlinear::{
    DoubleWell, Followed, GROUPS, Observable, expected, groups, sampled,
};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/nonlinear-equilibrium",
    title: "Two nodes on bonds with two wells: moments of exp(-V/kT) and the probability of a well",
    source: "eq 4 of the note; quadrature of exp(-V/kT) over both displacements",
    cost: Profile::Default,
    run: Together(run),
};

/// Wells at stretches of 0.3, a barrier of 1.5 kT and 0.8 kT between the wells.
const TEMPERATURE: f64 = 0.01;
const WELLS: DoubleWell =
    DoubleWell { width: 0.3, barrier: 1.5 * TEMPERATURE, tilt: 0.4 * TEMPERATURE };

/// Named, with the unit of its quantity.
type Named = (&'static str, &'static str, Observable);

const OF_WELLS: [Named; 4] = [
    ("mean", "mean displacement of the first node", |u, _| u),
    ("second-moment", "mean square displacement of the second node", |_, v| v * v),
    ("upper-well", "probability that the first bond is in its upper well", |u, _| {
        f64::from(u8::from(u > 0.0))
    }),
    ("both-upper", "probability that both bonds are in their upper wells", |u, v| {
        f64::from(u8::from(u > 0.0 && v > u))
    }),
];

fn run(context: &Context<'_>) -> CaseResult {
    let chain = groups()?;
    let correlation = Correlation { function: CorrelationFunction::Gaussian, length: 1.3 };
    let correlated = CorrelatedMobility { mobility: 1.0, correlation, nugget: 0.1 };
    let coupled = Mobility::dense(chain.nodes.positions(), &chain.free, &correlated)?;
    let overdamped = |mobility, temperature| Dynamics::Overdamped {
        mobility,
        temperature,
        scheme: Scheme::LeimkuhlerMatthews,
    };
    let inertial = Dynamics::Inertial { density: 1.0, friction: 1.0, temperature: TEMPERATURE };
    let followed = |relative| Followed { relative, settled: 500, steps: 10_000 };
    let mut claims = Vec::new();
    for (name, method, dynamics, relative) in [
        (
            "leimkuhler-matthews",
            "Leimkuhler-Matthews, dense mobility that couples nodes, z = 0.3",
            overdamped(coupled, TEMPERATURE),
            0.3,
        ),
        ("baoab", "BAOAB, gamma = 1, omega h = 0.4", inertial, 0.4),
    ] {
        context.progress(name);
        let observables = OF_WELLS.map(|of| of.2);
        let exact = expected((&WELLS, 1.0), (TEMPERATURE, 1.3), observables);
        let found = sampled((&WELLS, 1.0), &dynamics, followed(relative), observables)?;
        let id = format!("double-well/{name}");
        let reason = "second order in the step: 0.3 % in the variance of the stiffest mode for a fourth of the curvature that is not constant; a bond crosses its barrier some hundred times";
        claims.extend(of_group(
            context,
            (&id, method),
            &OF_WELLS,
            (&found, &exact),
            (0.005, reason),
        ));
    }
    Ok(claims)
}

fn of_group(
    context: &Context<'_>,
    (id, method): (&str, &str),
    named: &[Named],
    (found, exact): (&[Measured], &[f64]),
    (bias_bound, reason): (f64, &str),
) -> Vec<Claim> {
    let method = format!("{method}; {GROUPS} groups over 10,000 steps");
    let claim = |((&(name, quantity, _), &found), &exact): ((&Named, &Measured), &f64)| {
        let subject = context.subject(format!("{id}/{name}"), quantity, &method);
        subject.relative(found, exact).monte_carlo(bias_bound).because(reason)
    };
    named.iter().zip(found).zip(exact).map(claim).collect()
}
