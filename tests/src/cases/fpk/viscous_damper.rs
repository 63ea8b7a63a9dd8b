//! The building with a viscous damper of the paper's section 4.1.

use fpk_sph::{Config, Error, Method, Remapping};
use reference_problems::fpk::problem::Problem;

use super::stationary_oscillators::remapped as fresh_lattices;
use super::{ExceedanceEstimator, Judge, asked};
use crate::cases::prelude::*;

const SOURCE: &str =
    "Canor & Denoël 2013, section 4.1; references by grid, Monte Carlo and importance sampling";

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/viscous-damper-flow-map",
    title: "Building with a viscous damper in an earthquake, flow-map fit, 2,401 particles",
    source: SOURCE,
    cost: Profile::Quick,
    run: Together(run),
};

pub(crate) const REMAPPED: Case = Case {
    id: "fpk-sph/viscous-damper-remapped",
    title: "Building with a viscous damper in an earthquake, with and without remeshing",
    source: SOURCE,
    cost: Profile::Quick,
    run: Together(remapped),
};

/// While the noise is strong.
const SHAKING: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
/// When it has died away.
const AFTER: [f64; 3] = [7.0, 8.0, 10.0];

/// Smallest probability that is claimed.
const FLOW_MAP_FLOOR: f64 = 1e-7;

fn run(context: &Context<'_>) -> CaseResult {
    let problem = Problem::viscous_damper()?;
    let config = problem.density_config(1.0)?;
    let times = [SHAKING.as_slice(), AFTER.as_slice()].concat();
    let run = problem.density(&config, &asked(&times, &problem, true))?;
    let method = run.words("flow-map fit, box of 7 sigma");
    let lines = context.lines("flow-map-fit", method);
    let judge = Judge { problem: &problem, run: &run, lines };
    let reason = "truncation of the cubic fit, also after the noise has died away";
    let within = |tolerance| Criterion::Within { tolerance, reason };
    let tail = "truncation of the fit and a limit taken as linear in a part of a cell, also on the slow manifold";
    let tail = Criterion::Within { tolerance: 0.02, reason: tail };
    Ok(vec![
        judge.worst_moment([2, 0], &times, within(1.5e-3))?,
        judge.worst_moment([0, 2], &times, within(1.5e-3))?,
        judge.worst_correlation(&times, within(1e-3))?,
        judge.worst_exceedance(ExceedanceEstimator::Cell, &times, FLOW_MAP_FLOOR, tail)?,
    ])
}

/// Effect of remeshing: none on the moments and on the tail while there is noise, a worse far tail after it.
fn remapped(context: &Context<'_>) -> CaseResult {
    let problem = Problem::viscous_damper()?;
    let config = problem.density_config(1.0)?;
    let remapping = Remapping { most_uneven: 1.0, ..Remapping::MEASURED };
    let times = [6.0, 7.0, 8.0, 10.0];
    let mut claims = Vec::new();
    let folded = "P = 4.8e-9 at t = 6 and 3.5e-11 at t = 8: a box of 7 sigma holds this tail, of 6 it was 13 % and a factor of 20 off; \
                  remeshing loses it after the noise has died away";
    let band = |from, to| Criterion::AsMeasured { from, to, reason: folded };
    let mended = Criterion::Within { tolerance: 0.06, reason: folded };
    for (id, method, tails) in [
        ("without", Method::FlowMapFit, [mended, band(-0.1, 0.0)]),
        ("with", fresh_lattices(remapping, 40.0), [mended, band(0.4, 0.6)]),
    ] {
        let config = Config { method, ..config };
        let run = problem.density(&config, &asked(&times, &problem, true))?;
        let words = run.words(&format!("flow-map fit, box of 7 sigma, {id} remeshing"));
        let judge = Judge { problem: &problem, run: &run, lines: context.lines(id, words) };
        let reason = "truncation of the cubic fit";
        for powers in [[2, 0], [0, 2]] {
            let criterion = Criterion::Within { tolerance: 1.5e-3, reason };
            claims.push(judge.worst_moment(powers, &[6.0, 7.0, 8.0], criterion)?);
        }
        for (t, criterion) in [6.0, 8.0].into_iter().zip(tails) {
            claims.push(judge.exceedance(ExceedanceEstimator::Cell, 1.5, t, criterion)?);
        }
        if id == "with" {
            let reached = match &run.stopped {
                Some(Error::RemappingChangesMass { time, .. }) => *time,
                _ => f64::NAN,
            };
            let quantity = "time at which no lattice holds the cloud";
            let reason = "on the slow manifold the density is thinner than a spacing of an even lattice: a fresh one would \
                          change the mass by 3 %, and is refused";
            let subject = context.subject("with/ended", quantity, "").unit("s");
            claims.push(subject.measured(reached, (8.0, 10.0)).because(reason));
        }
    }
    Ok(claims)
}
