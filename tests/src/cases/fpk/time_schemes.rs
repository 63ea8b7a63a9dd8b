//! The schemes in time with few evaluations, on the damped building.

use figures::ErrorKind;
use fpk_sph::systems::ViscousDamper;
use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Scheme, Simulation, StepRule,
};
use work_precision::problems::fpk::oscillator::Oscillator;
use work_precision::problems::fpk::problem::Problem;

use super::worst;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/time-schemes",
    title: "Building with a viscous damper by schemes with few evaluations, flow-map fit",
    source: "Canor & Denoël 2013, section 4.1; references by a spectral grid",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const TIME: f64 = 6.0;

/// Name, scheme, particles along an axis, steps per period, tolerance of the worse second moment, most evaluations.
const RUNS: [(&str, Scheme, usize, f64, f64, f64); 3] = [
    ("lawson-runge-kutta-4", Scheme::LawsonRungeKutta4, 29, 20.0, 2e-3, 265.0),
    ("lawson-adams-bashforth-2", Scheme::LawsonAdamsBashforth2, 29, 40.0, 2e-3, 140.0),
    ("runge-kutta-chebyshev", Scheme::RungeKuttaChebyshev, 41, 20.0, 5e-4, 297.0),
];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let Oscillator::Damper(system) = &problem.system else {
        return Err("the scene holds another system".into());
    };
    let mut claims = Vec::new();
    for one in RUNS {
        claims.extend(by_scheme(context, (&problem, system), one)?);
    }
    Ok(claims)
}

/// Second moments and evaluations of a run.
fn by_scheme(
    context: &Context<'_>,
    (problem, system): (&Problem, &ViscousDamper),
    (id, scheme, count, steps_per_period, tolerance, most): (&str, Scheme, usize, f64, f64, f64),
) -> Result<Vec<Claim>, CaseError> {
    let combination = Method::FlowMapFit.combination();
    let step = StepRule::PeriodFraction { steps_per_period };
    let config = Config {
        method: Method::Custom(Combination { scheme, step, ..combination }),
        lattice: InitialLattice::box_of(count),
        reference_period: problem.system.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(system.clone(), &problem.law, &config)?;
    simulation.advance_to(TIME)?;
    let work = simulation.work();
    let method =
        format!("{count}^2 particles, {} steps, {} evaluations", work.steps, work.evaluations);
    let lines = Lines { context, id, method };
    let reason = "truncation of the cubic fit, and that of the scheme: a twentieth or a fortieth of the period";
    let mut moments = Vec::new();
    for (powers, name, quantity, unit) in [
        ([2, 0], "second-moment-q", "E[q^2]", "m^2"),
        ([0, 2], "second-moment-v", "E[v^2]", "m^2/s^2"),
    ] {
        let reference = problem.reference.moment(powers, TIME).ok_or("no reference")?;
        let value = simulation.raw_moment(powers);
        let criterion = Criterion::Within { tolerance, reason };
        let what = (name, quantity, unit);
        moments.push(lines.judge(what, ErrorKind::Relative, value, reference, criterion));
    }
    let name = format!("{id}/second-moments/worst");
    let reason =
        "Runge-Kutta 4 in steps of a fortieth takes 480; the rest is the limit by diffusion";
    let evaluations = work.evaluations as f64;
    Ok(vec![
        worst(context, (&name, &format!("t = {TIME}")), moments)?,
        lines.measured(
            ("evaluations", "evaluations of the velocity", ""),
            evaluations,
            (0.9 * most, most),
            reason,
        ),
    ])
}
