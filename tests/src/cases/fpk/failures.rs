//! Where the method leaves its range it says so.

use fpk_sph::{Combination, Config, Error, Method};
use reference_problems::fpk::problem::Problem;
use result_figures::Measured;

use super::asked;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/failures",
    title: "The paper's method with a small support ends in a typed error, at a time",
    source: "measured threshold: 8 neighbours clump",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let period = problem.system.period();
    let paper = reference_problems::fpk::methods::papers_config(period);
    let narrow = Combination { support_over_spacing: 1.5, ..Method::CanorDenoel2013.combination() };
    Ok(vec![ended(
        context,
        &problem,
        &Config { method: Method::Custom(narrow), ..paper },
        "canor-denoel-2013/support-1.5",
        |error| matches!(error, Error::StepCollapsed { .. }),
        (1.0, 6.0),
        "8 neighbours: particles clump and the Courant step collapses below 1e-6 of a period, before the run's end at 6; when is \
         up to roundoff: seen at 1.75, 3.28 and 3.57 with the same formulas summed in another order or another last bit of the \
         damper's power; the prototype stalled at 3.2",
    )?])
}

/// The time at which a run ended in the error that was expected; NaN, which fails, for any other end.
fn ended(
    context: &Context<'_>,
    problem: &Problem,
    config: &Config<2>,
    name: &str,
    expected: impl Fn(&Error) -> bool,
    (from, to): (f64, f64),
    reason: &str,
) -> Result<Claim, CaseError> {
    context.progress(name);
    let times: Vec<f64> = (1..=40).map(|k| f64::from(k) * 0.25).collect();
    let run = problem.density(config, &asked(&times, problem, false))?;
    let reached = run.rows.last().map_or(0.0, |row| row.t);
    let (time, words) = match &run.stopped {
        Some(error) if expected(error) => (reached, error.to_string()),
        Some(error) => (f64::NAN, format!("another error: {error}")),
        None => (f64::NAN, "the run did not end early".to_owned()),
    };
    let subject = context.subject(name, "last output time before the typed error", "s", &words);
    Ok(Claim::as_measured(subject, Measured::exact(time), from, to, reason))
}
