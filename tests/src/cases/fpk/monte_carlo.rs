//! The rival: Monte Carlo on the same declarations.

use reference_problems::fpk::problem::Problem;
use result_figures::{ErrorKind, Measured};
use scenes::fpk::monte_carlo::{SampledRun, Sampling};

use super::{POWERS, asked, moment_words};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/monte-carlo",
    title: "Monte Carlo on the same systems: Strang splitting, and the paper's forward Euler",
    source: "Canor & Denoël 2013, section 4.1: 1e5 samples by forward Euler",
    cost: Profile::Quick,
    schedule: Schedule::Alone,
    run,
};

const TIMES: [f64; 3] = [2.0, 4.0, 6.0];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    let (strang_paths, euler_paths) = match context.profile {
        Profile::Quick => (25_000, 10_000),
        Profile::Default => (25_000, 20_000),
        Profile::Full => (100_000, 20_000),
    };
    for (problem, scene, euler_growth) in [
        (Problem::viscous_damper()?, "viscous-damper", (0.03, 0.1)),
        (Problem::linear_oscillator()?, "linear-oscillator", (0.04, 0.12)),
    ] {
        context.progress(scene);
        let strang = Sampling { paths: strang_paths, step: 0.02, seed: 1 };
        claims.extend(strang_claims(context, &problem, scene, &strang)?);
        let euler = Sampling { paths: euler_paths, step: 0.0025, seed: 2 };
        claims.push(euler_claim(context, (&problem, scene), &euler, euler_growth)?);
    }
    Ok(claims)
}

fn words(integrator: &str, sampling: &Sampling, run: &SampledRun) -> String {
    let Sampling { paths, step, .. } = sampling;
    format!("Monte Carlo, {integrator}, {paths} paths, step {step} s, {:.2} s CPU", run.cpu_seconds)
}

fn strang_claims(
    context: &Context<'_>,
    problem: &Problem,
    scene: &str,
    sampling: &Sampling,
) -> Result<Vec<Claim>, CaseError> {
    let asked = asked(&TIMES, problem, false);
    let run = problem.sampled(sampling, &asked)?;
    let method = words("Strang", sampling, &run);
    let mut claims = Vec::new();
    for row in &run.rows {
        let t = row.t;
        for (powers, estimate) in POWERS.into_iter().zip(&row.moments) {
            let (name, quantity, unit) = moment_words(powers);
            let Some(reference) = problem.reference.moment(powers, t) else { continue };
            let subject =
                context.subject(&format!("{scene}/strang/{name}/t{t}"), quantity, unit, &method);
            let measured =
                Measured { value: estimate.value, standard_error: estimate.standard_error() };
            let reason = "weak error of Strang splitting at this step: 1e-4 in the coupled study";
            let criterion = Criterion::MonteCarlo { bias_bound: 5e-4, reason };
            // The cross moment passes near zero: its error is measured as it is.
            let kind = if powers == [1, 1] { ErrorKind::Absolute } else { ErrorKind::Relative };
            claims.push(Claim::judge(subject, kind, measured, reference, criterion));
        }
        for (threshold, estimate) in asked.thresholds.iter().zip(&row.exceedances) {
            let reference = problem.reference.exceedance(*threshold, t);
            // A hundred hits have a standard error of 10 %: fewer would pass whatever the integrator does.
            let Some(reference) = reference.filter(|r| r.value * sampling.paths as f64 >= 100.0)
            else {
                continue;
            };
            let name = format!("{scene}/strang/exceedance/threshold-{threshold}/t{t}");
            let subject = context.subject(&name, &format!("P(|q| > {threshold})"), "", &method);
            let measured =
                Measured { value: estimate.value, standard_error: estimate.standard_error() };
            let reason = "weak error of Strang splitting at this step";
            let criterion = Criterion::MonteCarlo { bias_bound: 1e-3, reason };
            claims.push(Claim::judge(subject, ErrorKind::Relative, measured, reference, criterion));
        }
    }
    Ok(claims)
}

fn euler_claim(
    context: &Context<'_>,
    (problem, scene): (&Problem, &str),
    sampling: &Sampling,
    (from, to): (f64, f64),
) -> Result<Claim, CaseError> {
    let run = problem.sampled_by_euler(sampling, &asked(&[6.0], problem, false))?;
    let row = run.at(6.0).ok_or("no row at t = 6")?;
    let subject = context.subject(
        &format!("{scene}/forward-euler/second-moment-q/t6"),
        "E[q^2]",
        "m^2",
        &words("forward Euler", sampling, &run),
    );
    let reference = problem.reference.moment([2, 0], 6.0).ok_or("no reference")?;
    let measured =
        Measured { value: row.moments[0].value, standard_error: row.moments[0].standard_error() };
    let reason = "forward Euler grows by exp(w^2 dt t) in energy, 16 % undamped, less what damping takes; the \
                  samples know it to 1.1 %";
    let criterion = Criterion::AsMeasured { from, to, reason };
    Ok(Claim::judge(subject, ErrorKind::Relative, measured, reference, criterion))
}
