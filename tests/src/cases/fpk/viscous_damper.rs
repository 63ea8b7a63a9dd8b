//! The building with a viscous damper of the paper's section 4.1, by the better method.

use figures::Measured;
use fpk_sph::{Config, Error, Method, Remapping};
use work_precision::charts;
use work_precision::problems::fpk::problem::Problem;

use super::stationary_oscillators::remapped as fresh_lattices;
use super::{ExceedanceEstimator, Judge, asked};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

const SOURCE: &str =
    "Canor & Denoël 2013, section 4.1; references by grid, Monte Carlo and importance sampling";

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/viscous-damper",
    title: "Building with a viscous damper in an earthquake, 1,681 particles",
    source: SOURCE,
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: scene,
};

pub(crate) const REFINED: Case = Case {
    id: "fpk-sph/viscous-damper-refined",
    title: "Building with a viscous damper in an earthquake, 6,561 particles",
    source: SOURCE,
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: refined,
};

pub(crate) const FLOW_MAP_FIT: Case = Case {
    id: "fpk-sph/viscous-damper-flow-map",
    title: "Building with a viscous damper in an earthquake, flow-map fit, 1,681 particles",
    source: SOURCE,
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: flow_map_fit,
};

pub(crate) const REMAPPED: Case = Case {
    id: "fpk-sph/viscous-damper-remapped",
    title: "Building with a viscous damper in an earthquake, with and without fresh lattices",
    source: SOURCE,
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: remapped,
};

/// While the noise is strong.
const SHAKING: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
/// When it has died away.
const AFTER: [f64; 3] = [7.0, 8.0, 10.0];

fn scene(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let config = problem.density_config(1.0)?;
    let times = [SHAKING.as_slice(), AFTER.as_slice()].concat();
    let run = problem.density(&config, &asked(&times, &problem, true))?;
    let method = run.words("log-density fit, box of 6 sigma");
    let judge = Judge { context, problem: &problem, run: &run, id: "log-density-fit", method };
    let mut claims = moments(
        &judge,
        0.01,
        "truncation of the quadratic fit at a spacing of 0.3 sigma, of second order; the prototype lost 0.9 % at t = 6",
    )?;
    claims.extend(tail(&judge)?);
    claims.extend(after(&judge)?);
    let drawing = charts::fpk::exceedance(context, &problem, "fpk-damper")?;
    let svg = drawing.into_svg().ok_or("a page and no picture")?;
    context.show_chart("Probability of exceedance over time", svg);
    Ok(claims)
}

fn refined(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let config = problem.density_config(2.0)?;
    let run = problem.density(&config, &asked(&SHAKING, &problem, false))?;
    let method = run.words("log-density fit, box of 6 sigma");
    let judge = Judge { context, problem: &problem, run: &run, id: "log-density-fit", method };
    moments(&judge, 0.003, "a quarter of the truncation at half the spacing: 0.22 to 0.25 %")
}

fn moments(judge: &Judge<'_>, tolerance: f64, reason: &str) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for t in SHAKING {
        for powers in [[2, 0], [0, 2]] {
            claims.push(judge.moment(powers, t, Criterion::Within { tolerance, reason })?);
        }
        claims.push(judge.correlation(t, Criterion::Within { tolerance, reason })?);
    }
    Ok(claims)
}

/// Smallest probability that is claimed.
const FLOOR: f64 = 1e-9;

fn tail(judge: &Judge<'_>) -> Result<Vec<Claim>, CaseError> {
    let reason = "what 1 % of the variance does to a tail of 6 sigma, (6^2/2) 0.01 / ln 10 = 0.08, less what cancels; \
                  the prototype was within 0.05";
    let mut claims = Vec::new();
    for (threshold, t, _) in judge.exceedances_from(&SHAKING, FLOOR) {
        let criterion = Criterion::Within { tolerance: 0.06, reason };
        claims.push(judge.exceedance(ExceedanceEstimator::Cell, threshold, t, criterion)?);
    }
    let staircase = "counting particles quantises P by whole layers of the lattice, and ends with the last layer; \
                     seen at 0.027 and 0.030, and at 0.09 before the fit held to the cloud's Gaussian at the rim";
    for estimator in [ExceedanceEstimator::Indicator, ExceedanceEstimator::LogInterpolated] {
        claims.push(judge.worst_exceedance(estimator, &[6.0], FLOOR, (0.02, 0.12), staircase)?);
    }
    Ok(claims)
}

/// The noise dies, the damper stops the mass where the spring is weak, and the cloud collapses on a slow manifold.
fn after(judge: &Judge<'_>) -> Result<Vec<Claim>, CaseError> {
    let reason = "without noise nothing mends the error of t = 6, and the cloud collapses on the slow manifold \
                  eta |v|^alpha = w^2 |q|, across which the fit cannot resolve it";
    let mut claims = Vec::new();
    for t in AFTER {
        for powers in [[2, 0], [0, 2]] {
            claims.push(judge.moment(
                powers,
                t,
                Criterion::AsMeasured { from: -0.015, to: -0.005, reason },
            )?);
        }
        for (threshold, t, _) in judge.exceedances_from(&[t], FLOOR) {
            let criterion = Criterion::AsMeasured { from: -0.03, to: 0.02, reason };
            claims.push(judge.exceedance(ExceedanceEstimator::Cell, threshold, t, criterion)?);
        }
    }
    Ok(claims)
}

/// Smallest probability that is claimed of the flow-map fit.
const FLOW_MAP_FLOOR: f64 = 1e-7;

fn flow_map_fit(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let config = problem.density_config(1.0)?;
    let config = Config { method: Method::FlowMapFit, ..config };
    let times = [SHAKING.as_slice(), AFTER.as_slice()].concat();
    let run = problem.density(&config, &asked(&times, &problem, true))?;
    let method = run.words("flow-map fit, box of 6 sigma");
    let judge = Judge { context, problem: &problem, run: &run, id: "flow-map-fit", method };
    let reason = "truncation of the cubic fit; seen within 0.081 %, the most at t = 1 in E[v^2], and within 0.05 % after the \
                  noise has died away";
    let tail = "truncation of the fit and a limit taken as linear in a part of a cell; seen within 0.008 down to 1e-7, also \
                on the slow manifold at t = 7, 8 and 10";
    let mut claims = Vec::new();
    for &t in &times {
        let criterion = Criterion::Within { tolerance: 2e-3, reason };
        for powers in [[2, 0], [0, 2]] {
            claims.push(judge.moment(powers, t, criterion)?);
        }
        claims.push(judge.correlation(t, criterion)?);
    }
    for (threshold, t, _) in judge.exceedances_from(&times, FLOW_MAP_FLOOR) {
        let criterion = Criterion::Within { tolerance: 0.02, reason: tail };
        claims.push(judge.exceedance(ExceedanceEstimator::Cell, threshold, t, criterion)?);
    }
    Ok(claims)
}

/// What fresh lattices buy: nothing in the moments, the far tail while there is noise.
fn remapped(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let problem = Problem::viscous_damper()?;
    let config = problem.density_config(1.0)?;
    let remapping = Remapping { most_uneven: 1.0, ..Remapping::MEASURED };
    let times = [6.0, 7.0, 8.0, 10.0];
    let mut claims = Vec::new();
    for (id, method, bands) in [
        ("without", Method::FlowMapFit, [(0.06, 0.2), (0.9, 1.8)]),
        ("with", fresh_lattices(remapping, 40.0), [(-0.06, 0.03), (-0.6, -0.15)]),
    ] {
        let config = Config { method, ..config };
        let run = problem.density(&config, &asked(&times, &problem, true))?;
        let words = run.words(&format!("flow-map fit, box of 6 sigma, {id} fresh lattices"));
        let judge = Judge { context, problem: &problem, run: &run, id, method: words };
        let reason = "truncation of the cubic fit; seen within 0.045 % with and without";
        for t in [6.0, 7.0, 8.0] {
            for powers in [[2, 0], [0, 2]] {
                let criterion = Criterion::Within { tolerance: 2e-3, reason };
                claims.push(judge.moment(powers, t, criterion)?);
            }
        }
        for (t, (from, to)) in [6.0, 8.0].into_iter().zip(bands) {
            let reason = "P = 4.8e-9 at t = 6 and 3.5e-11 at t = 8: cells at the rim of the first lattice have folded; a fresh \
                          one mends that while the noise feeds the tail, and not after";
            let criterion = Criterion::AsMeasured { from, to, reason };
            claims.push(judge.exceedance(ExceedanceEstimator::Cell, 1.5, t, criterion)?);
        }
        if id == "with" {
            let reached = match &run.stopped {
                Some(Error::FreshLatticeChanges { time, .. }) => *time,
                _ => f64::NAN,
            };
            let subject =
                context.subject("with/ended", "time at which no lattice holds the cloud", "s", "");
            let reason = "on the slow manifold the density is thinner than a spacing of an even lattice: a fresh one would \
                          change the mass by 3 %, and is refused";
            claims.push(Claim::as_measured(subject, Measured::exact(reached), 8.0, 10.0, reason));
        }
    }
    Ok(claims)
}
