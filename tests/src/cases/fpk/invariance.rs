//! Same bits whatever the number of threads, and after a restart.

use fpk_sph::{Config, Simulation};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::Problem;
use scenes::fpk::monte_carlo::Sampling;
use sde_integrators::Sde;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/invariance",
    title: "Threads and restarts change no bit",
    source: "by construction: every particle writes its own entry, sums have one order",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const TIMES: [f64; 2] = [1.0, 2.0];

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for (problem, scene) in [
        (Problem::viscous_damper()?, "viscous-damper"),
        (Problem::linear_oscillator()?, "linear-oscillator"),
    ] {
        let config = problem.density_config(1.0)?;
        match problem.system.clone() {
            Oscillator::Linear(system) => {
                claims.extend(density(context, &problem, scene, &system, &config)?);
            }
            Oscillator::Damper(system) => {
                claims.extend(density(context, &problem, scene, &system, &config)?);
            }
        }
        claims.extend(sampled(context, &problem, scene)?);
    }
    Ok(claims)
}

fn density<S: Sde<2, 1> + Clone + Send + Sync>(
    context: &Context<'_>,
    problem: &Problem,
    scene: &str,
    system: &S,
    config: &Config<2>,
) -> Result<Vec<Claim>, CaseError> {
    let whole = || -> Result<Vec<u64>, CaseError> {
        let mut simulation = Simulation::new(system.clone(), &problem.law, config)?;
        simulation.advance_to(TIMES[0])?;
        simulation.advance_to(TIMES[1])?;
        Ok(bits(&simulation))
    };
    let (one, mut claims) =
        over_threads(context, &format!("{scene}/density"), "no sum depends on the threads", whole)?;
    let mut first = Simulation::new(system.clone(), &problem.law, config)?;
    first.advance_to(TIMES[0])?;
    let mut snapshot = Vec::new();
    first.snapshot(&mut snapshot)?;
    let mut resumed = Simulation::new(system.clone(), &problem.law, config)?;
    resumed.restore(snapshot.as_slice())?;
    resumed.advance_to(TIMES[1])?;
    let other = bits(&resumed);
    let name = format!("{scene}/density/restart");
    let subject = context.subject(&name, QUANTITY, "", "snapshot at t = 1, restored");
    let reason = "the snapshot holds the whole state";
    claims.push(Claim::same_bits(subject, different(&one, &other), one.len(), reason));
    Ok(claims)
}

fn sampled(context: &Context<'_>, problem: &Problem, scene: &str) -> Result<Vec<Claim>, CaseError> {
    let sampling = Sampling { paths: 20_000, step: 0.02, seed: 3 };
    let asked = super::asked(&TIMES, problem, false);
    let whole = || -> Result<Vec<u64>, CaseError> {
        let rows = problem.sampled(&sampling, &asked)?.rows;
        let estimates = rows.iter().flat_map(|row| row.moments.iter().chain(&row.exceedances));
        Ok(estimates.map(|estimate| estimate.value.to_bits()).collect())
    };
    let reason = "blocks of 4,096 paths are summed in order";
    over_threads(context, &format!("{scene}/monte-carlo"), reason, whole).map(|(_, claims)| claims)
}

const QUANTITY: &str = "values whose bits differ";

/// The bits on one thread, and the claims that two and eight give the same.
pub(super) fn over_threads(
    context: &Context<'_>,
    name: &str,
    reason: &str,
    whole: impl Fn() -> Result<Vec<u64>, CaseError> + Sync,
) -> Result<(Vec<u64>, Vec<Claim>), CaseError> {
    let on = |threads: usize| -> Result<Vec<u64>, CaseError> {
        context.progress(&format!("{name}, {threads} threads"));
        rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(&whole)
    };
    let one = on(1)?;
    let mut claims = Vec::new();
    for threads in [2, 8] {
        let other = on(threads)?;
        let method = format!("{threads} threads against 1");
        let subject = context.subject(&format!("{name}/threads-{threads}"), QUANTITY, "", &method);
        claims.push(Claim::same_bits(subject, different(&one, &other), one.len(), reason));
    }
    Ok((one, claims))
}

fn bits<S: Sde<2, 1>>(simulation: &Simulation<S, 2, 1>) -> Vec<u64> {
    simulation.positions().iter().flatten().map(|x| x.to_bits()).collect()
}

/// How many entries differ; all of them where the lengths do.
fn different(one: &[u64], other: &[u64]) -> usize {
    if one.len() == other.len() {
        one.iter().zip(other).filter(|(a, b)| a != b).count()
    } else {
        one.len().max(1)
    }
}
