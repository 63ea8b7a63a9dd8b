//! The largest stable step of a linear oscillator: the spectral radius of one step against formulas.

use figures::{ErrorKind, Measured, Reference};
use work_precision::problems::sde::oscillator_limits::{Limited, METHODS, formula, measured};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/oscillator-stability",
    title: "largest stable step of a linear oscillator, by the spectral radius of one step",
    source: "trace and determinant of one step; an independent script, values below",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

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
