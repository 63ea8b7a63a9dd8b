//! The scheme in time with one evaluation a step, on the damped building and on one that yields.

use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Scheme, Simulation,
};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::{Problem, bouc_wen};
use result_figures::ErrorKind;
use vibrating_systems::ViscousDamper;

use super::worst;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/time-schemes",
    title: "Buildings with a damper and with hysteresis by one evaluation a step, flow-map fit",
    source: "Canor & Denoël 2013, sections 4.1 and 4.2; references by a spectral grid and by Monte Carlo",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const TIME: f64 = 6.0;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let Oscillator::Damper(system) = &problem.system else {
        return Err("the scene holds another system".into());
    };
    let mut claims = of_the_damper(context, &problem, system)?;
    claims.extend(negligible(context)?);
    Ok(claims)
}

/// Time of the observation of the yielding building.
const YIELDING: f64 = 3.6;

/// Second moments and evaluations of the yielding building where thin cells with 1 % of the second moments limit no step.
fn negligible(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (system, law, references) = bouc_wen()?;
    let combination = Combination {
        scheme: Scheme::LawsonAdamsBashforth2,
        negligible: 0.01,
        ..Method::FlowMapFit.combination()
    };
    let config = Config {
        method: Method::Custom(combination),
        lattice: InitialLattice::Ball { reach: 5.0, spacing: 0.6 },
        reference_period: system.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(system, &law, &config)?;
    simulation.advance_to(YIELDING)?;
    let work = simulation.work();
    let method = format!(
        "{} particles, {} steps, {} evaluations",
        simulation.n_particles(),
        work.steps,
        work.evaluations
    );
    let id = "negligible";
    let lines = Lines { context, id, method };
    let reason = "truncation of the cubic fit across kinks, 0.6 % with every cell stable, and the cells left out";
    let mut moments = Vec::new();
    for (powers, name, quantity, unit) in [
        ([2, 0, 0], "second-moment-q", "E[q^2]", "m^2"),
        ([0, 2, 0], "second-moment-v", "E[v^2]", "m^2/s^2"),
        ([0, 0, 2], "second-moment-z", "E[z^2]", ""),
    ] {
        let reference = references.moment(powers, YIELDING).ok_or("no reference")?;
        let value = simulation.raw_moment(powers);
        let criterion = Criterion::Within { tolerance: 1e-2, reason };
        let what = (name, quantity, unit);
        moments.push(lines.judge(what, ErrorKind::Relative, value, reference, criterion));
    }
    Ok(vec![
        worst(
            context,
            (&format!("{id}/second-moments/worst"), &format!("t = {YIELDING}")),
            moments,
        )?,
        lines.measured(
            ("evaluations", "evaluations of the velocity", ""),
            work.evaluations as f64,
            (100.0, 112.0),
            "507 with every cell stable",
        ),
    ])
}

/// Second moments and evaluations of the damper.
fn of_the_damper(
    context: &Context<'_>,
    problem: &Problem,
    system: &ViscousDamper,
) -> Result<Vec<Claim>, CaseError> {
    let (id, scheme) = ("lawson-adams-bashforth-2", Scheme::LawsonAdamsBashforth2);
    let combination = Combination { scheme, ..Method::FlowMapFit.combination() };
    let config = Config {
        method: Method::Custom(combination),
        lattice: InitialLattice::box_of(29),
        reference_period: problem.system.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(system.clone(), &problem.law, &config)?;
    simulation.advance_to(TIME)?;
    let work = simulation.work();
    let method = format!("29^2 particles, {} steps, {} evaluations", work.steps, work.evaluations);
    let lines = Lines { context, id, method };
    let reason = "truncation of the cubic fit, and that of the scheme: a fortieth of the period";
    let mut moments = Vec::new();
    for (powers, name, quantity, unit) in [
        ([2, 0], "second-moment-q", "E[q^2]", "m^2"),
        ([0, 2], "second-moment-v", "E[v^2]", "m^2/s^2"),
    ] {
        let reference = problem.reference.moment(powers, TIME).ok_or("no reference")?;
        let value = simulation.raw_moment(powers);
        let criterion = Criterion::Within { tolerance: 2e-3, reason };
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
            (126.0, 140.0),
            reason,
        ),
    ])
}
