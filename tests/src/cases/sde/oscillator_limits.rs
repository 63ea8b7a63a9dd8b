//! The largest stable step of a linear oscillator: the spectral radius of one step against formulas.

use sde_integrators::{
    Baoab, EulerMaruyama, Heun, Integrator, SemiImplicitEuler, Shark, StateSpace, StepError,
};

use crate::case::{Case, CaseError, Context, Profile};
use crate::claim::{Criterion, Measured, Reference};
use crate::report::{Claim, ErrorKind};
use crate::sde::linear::probe;
use crate::sde::problems::Oscillator;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/oscillator-stability",
    title: "largest stable step of a linear oscillator, by the spectral radius of one step",
    source: "trace and determinant of one step; an independent script, values below",
    cost: Profile::Quick,
    run,
};

/// A method with a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Limited {
    EulerMaruyama,
    SemiImplicitEuler,
    Baoab,
    Heun,
    Shark,
}

/// All of them, with their names.
pub(crate) const METHODS: &[(&str, Limited)] = &[
    ("Euler-Maruyama", Limited::EulerMaruyama),
    ("semi-implicit Euler", Limited::SemiImplicitEuler),
    ("BAOAB", Limited::Baoab),
    ("Heun", Limited::Heun),
    ("ShARK", Limited::Shark),
];

/// What the survey's code found on a grid, to the digits it gives: `xi`, Euler-Maruyama, semi-implicit Euler, ShARK and
/// Heun.
const SURVEY: [(f64, [f64; 3]); 3] =
    [(0.01, [0.020, 1.99, 0.445]), (0.05, [0.100, 1.90, 0.80]), (0.2, [0.40, 1.64, 1.40])];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for &(name, method) in METHODS {
        let id = name.to_lowercase().replace(' ', "-");
        for xi in [0.01, 0.05, 0.2, 0.9] {
            let how = format!("{name}, bisection of the spectral radius of one step");
            let found = Measured::exact(measured(method, xi)?);
            let subject =
                context.subject(&format!("{id}/xi-{xi}"), "largest stable h omega", "", &how);
            let reason = "bisection to 1e-9 of the limit";
            let criterion = Criterion::Within { tolerance: 1e-7, reason };
            let expected = Reference::exact(formula(method, xi));
            claims.push(Claim::judge(subject, ErrorKind::Relative, found, expected, criterion));
            let published = SURVEY.iter().find(|row| row.0.to_bits() == xi.to_bits());
            let column = match method {
                Limited::EulerMaruyama => Some(0),
                Limited::SemiImplicitEuler => Some(1),
                Limited::Heun | Limited::Shark => Some(2),
                Limited::Baoab => None,
            };
            if let (Some((_, values)), Some(column)) = (published, column) {
                let subject = context.subject(
                    &format!("{id}/survey/xi-{xi}"),
                    "largest stable h omega against an independent script",
                    "",
                    &how,
                );
                let reason = "the script's grid of 1 %";
                let criterion = Criterion::Within { tolerance: 0.02, reason };
                let expected = Reference::exact(values[column]);
                claims.push(Claim::judge(subject, ErrorKind::Relative, found, expected, criterion));
            }
        }
    }
    Ok(claims)
}

/// The limit of `h omega` by formula, for `xi < 1`.
pub(crate) fn formula(method: Limited, xi: f64) -> f64 {
    match method {
        Limited::EulerMaruyama => 2.0 * xi,
        Limited::SemiImplicitEuler => 2.0 * (f64::hypot(1.0, xi) - xi),
        Limited::Baoab => 2.0,
        Limited::Heun | Limited::Shark => explicit_second_order(xi),
    }
}

/// The limit of the code.
pub(crate) fn measured(method: Limited, xi: f64) -> Result<f64, CaseError> {
    match method {
        Limited::EulerMaruyama => edge(xi, &EulerMaruyama),
        Limited::SemiImplicitEuler => edge(xi, &SemiImplicitEuler),
        Limited::Baoab => edge(xi, &Baoab),
        Limited::Heun => edge(xi, &Heun),
        Limited::Shark => edge(xi, &Shark),
    }
}

/// The first angle at which the spectral radius exceeds 1, sought in factors of 1.02 and bisected.
fn edge<I>(xi: f64, method: &I) -> Result<f64, CaseError>
where
    I: Integrator<StateSpace<Oscillator>, 2, 1>,
{
    let radius = |angle: f64| -> Result<f64, StepError> {
        let system = Oscillator { frequency: 2.0, damping_ratio: xi, intensity: 0.7 };
        let nothing = |_: &[f64; 2], _: &I::Memory| [0.0; 0];
        let (map, _) = probe(&StateSpace(system), method, angle / system.frequency, nothing)?;
        Ok(map.spectral_radius())
    };
    let mut above = 1e-3;
    while radius(above)? <= 1.0 {
        above *= 1.02;
        if above > 1e3 {
            return Err("no limit of stability below h omega = 1000".into());
        }
    }
    let mut below = above / 1.02;
    for _ in 0..40 {
        let middle = 0.5 * (below + above);
        if radius(middle)? <= 1.0 { below = middle } else { above = middle }
    }
    Ok(below)
}

/// `|1 + z + z^2/2| = 1` at the eigenvalue `z = h omega (-xi + i sqrt(1 - xi^2))` of the oscillator, by bisection.
fn explicit_second_order(xi: f64) -> f64 {
    let amplification = |angle: f64| {
        let (x, y) = (-xi * angle, (1.0 - xi * xi).max(0.0).sqrt() * angle);
        f64::hypot(1.0 + x + 0.5 * (x * x - y * y), y + x * y)
    };
    let mut above = 1e-3;
    while amplification(above) <= 1.0 {
        above *= 1.02;
    }
    let mut below = above / 1.02;
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        if amplification(middle) <= 1.0 { below = middle } else { above = middle }
    }
    below
}
