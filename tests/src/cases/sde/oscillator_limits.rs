//! The largest stable step of a linear oscillator: the spectral radius of one step against formulas.

use result_figures::ErrorKind;
use work_precision::problems::sde::oscillator_limits::{Limited, METHODS, formula, measured};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
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
    let (mut survey, mut place) = (0.0_f64, String::new());
    for &(name, method) in METHODS {
        let mut worst = 0.0_f64;
        for xi in [0.01, 0.05, 0.2, 0.9] {
            let found = measured(method, xi)?;
            worst = larger(worst, found / formula(method, xi) - 1.0);
            let published = SURVEY.iter().find(|row| row.0.to_bits() == xi.to_bits());
            let column = match method {
                Limited::EulerMaruyama => Some(0),
                Limited::SemiImplicitEuler => Some(1),
                Limited::Heun | Limited::Shark => Some(2),
                Limited::Baoab => None,
            };
            if let (Some((_, values)), Some(column)) = (published, column) {
                let error = found / values[column] - 1.0;
                if larger(survey, error).to_bits() != survey.to_bits() {
                    (survey, place) = (larger(survey, error), format!("{name}, xi = {xi}"));
                }
            }
        }
        let subject = context.subject(
            &name.to_lowercase().replace(' ', "-"),
            "worst relative error of the largest stable h omega",
            "",
            &format!(
                "{name}, bisection of the spectral radius of one step; xi = 0.01, 0.05, 0.2, 0.9"
            ),
        );
        let reason = "roundoff: eps over the slope of the spectral radius at its limit, 1e4 eps at the weakest damping";
        claims.push(Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 1e-11, reason));
    }
    let subject = context.subject(
        "survey",
        "worst relative difference of the largest stable h omega to an independent script",
        "",
        &format!("four methods, xi = 0.01, 0.05, 0.2; furthest: {place}"),
    );
    let reason = "the script's grid of 1 %";
    claims.push(Claim::within(subject, ErrorKind::Absolute, (survey, 0.0), 0.01, reason));
    Ok(claims)
}

/// The larger size; NaN stays.
fn larger(worst: f64, error: f64) -> f64 {
    if worst.is_nan() || error.is_nan() { f64::NAN } else { worst.max(error.abs()) }
}
