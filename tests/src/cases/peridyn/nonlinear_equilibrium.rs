//! The invariant measure `exp(-V/kT)` of bonds whose tension is not linear, sampled and by quadrature.

use peridyn_sde::law::SmoothStretch;
use peridyn_sde::{CompactMobility, Dynamics, Mobility, Scheme};
use result_figures::{ErrorKind, Measured, Reference};
use work_precision::problems::peridyn::nonlinear::{
    DoubleWell, End, Followed, GROUPS, Observable, expected, groups, sampled,
};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/nonlinear-equilibrium",
    title: "Two nodes on bonds with two wells, and on bonds that soften: moments of exp(-V/kT) and the probability of a well",
    source: "eq 4 of the note; quadrature of exp(-V/kT) over both displacements",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
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

const OF_SOFTENING: [Named; 2] = [
    ("second-moment", "mean square displacement of a node", |u, _| u * u),
    ("fourth-moment", "mean fourth power of the displacement of a node", |u, _| u.powi(4)),
];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let chain = groups()?;
    let compact = CompactMobility { length: 1.3, support: 2.6, mobility: 1.0, nugget: 0.1 };
    let coupled = Mobility::compact(chain.nodes.positions(), &chain.free, &compact)?;
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
            "Leimkuhler-Matthews, compact mobility that couples nodes, z = 0.3",
            overdamped(coupled, TEMPERATURE),
            0.3,
        ),
        ("baoab", "BAOAB, gamma = 1, omega h = 0.4", inertial, 0.4),
    ] {
        context.progress(name);
        let observables = OF_WELLS.map(|of| of.2);
        let exact = expected((&WELLS, 1.0), End::Free, (TEMPERATURE, 1.3), observables);
        let found = sampled((&WELLS, 1.0), End::Free, &dynamics, followed(relative), observables)?;
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
    // The fall begins at 0.2 deviations of a free bond and ends where no bond comes: 20 kT.
    let (temperature, strength) = (4e-4, 0.074);
    let law = SmoothStretch::new(0.95)?;
    let observables = OF_SOFTENING.map(|of| of.2);
    let exact = expected((&law, strength), End::Bonded, (temperature, 0.14), observables);
    let dynamics = overdamped(Mobility::identity(&chain.free, 1.0)?, temperature);
    let found = sampled((&law, strength), End::Bonded, &dynamics, followed(0.6), observables)?;
    let reason = "second order in the step. Linear bonds would have 4.5 and 11 % less";
    let method = "Leimkuhler-Matthews, z = 0.6; SmoothStretch of a width 0.95 that never breaks";
    claims.extend(of_group(
        context,
        ("smooth-stretch", method),
        &OF_SOFTENING,
        (&found, &exact),
        (0.003, reason),
    ));
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
        Claim::judge(
            context.subject(&format!("{id}/{name}"), quantity, "", &method),
            ErrorKind::Relative,
            found,
            Reference::exact(exact),
            Criterion::MonteCarlo { bias_bound, reason },
        )
    };
    named.iter().zip(found).zip(exact).map(claim).collect()
}
