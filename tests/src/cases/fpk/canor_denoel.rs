//! The paper's method as printed, on both oscillators: reproduced, with its errors.

use reference_problems::fpk::methods::papers_config;
use reference_problems::fpk::problem::Problem;
use scenes::fpk::density::DensityRun;

use super::{ExceedanceEstimator, Judge, asked};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/canor-denoel-2013",
    title: "The paper's method as printed: 50 x 33 particles, Courant 0.8, support/spacing 2.5",
    source: "Canor & Denoël 2013, sections 3 and 4.1",
    cost: Profile::Quick,
    run: Together(run),
};

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for (problem, scene, bands) in [
        (Problem::viscous_damper()?, "viscous-damper", &DAMPER),
        (Problem::linear_oscillator()?, "linear-oscillator", &LINEAR),
    ] {
        context.progress(scene);
        let run = problem.density(
            &papers_config(problem.system.period()),
            &asked(&[2.0, 6.0], &problem, false),
        )?;
        let method = run.words("Canor & Denoël 2013");
        let lines = context.lines(scene, method);
        let judge = Judge { problem: &problem, run: &run, lines };
        claims.extend(moments(&judge, bands)?);
        claims.push(steps(&judge, &run, bands.steps));
        claims.push(judge.worst_exceedance(
            ExceedanceEstimator::Indicator,
            &[6.0],
            // The lattice ends at 4 sigma: below 1e-5 the printed estimator has few particles behind it.
            1e-5,
            bands.tail,
        )?);
    }
    Ok(claims)
}

/// Where the errors were seen, with room for roundoff: particles that clump amplify it, and landing on other times on the
/// way to t = 6 moves the second moments by 2 %.
struct Bands {
    /// Relative error of `E[q^2]`, `E[v^2]` at t = 2, then at t = 6.
    moments: [Criterion<'static>; 4],
    steps: (f64, f64),
    tail: Criterion<'static>,
}

const MOMENTS: &str = "three errors, two of one sign and one of the other: an isotropic kernel on a sheared lattice, \
                       forward Euler's growth exp(w^2 dt t), kernel smoothing";
const CHAOTIC: &str = "chaos: the same three errors, which one unit in the last place of a force moves from -0.4 to 5 %";
const TAIL: &str = "kernel smoothing and forward Euler widen the cloud, its far layers are few";

const fn band(from: f64, to: f64) -> Criterion<'static> {
    Criterion::AsMeasured { from, to, reason: MOMENTS }
}

const fn chaotic(tolerance: f64) -> Criterion<'static> {
    Criterion::Within { tolerance, reason: CHAOTIC }
}

const fn tail(tolerance: f64) -> Criterion<'static> {
    Criterion::Within { tolerance, reason: TAIL }
}

/// The run is chaotic: one unit in the last place of the damper's power moves `E[q^2]` at t = 6 from an error of 1.3 % to
/// one of 5.3 %, the steps from 2,802 to 1,616 and the worst exceedance from 0.036 to 0.12.
const DAMPER: Bands = Bands {
    moments: [band(0.04, 0.08), band(-0.08, -0.03), chaotic(0.07), chaotic(0.04)],
    steps: (1_300.0, 3_300.0),
    tail: tail(0.3),
};

const LINEAR: Bands = Bands {
    moments: [band(0.03, 0.09), band(-0.08, -0.03), band(0.07, 0.16), chaotic(0.04)],
    steps: (1_000.0, 1_700.0),
    tail: tail(0.5),
};

fn moments(judge: &Judge<'_>, bands: &Bands) -> CaseResult {
    let mut claims = Vec::new();
    for (k, (t, powers)) in
        [(2.0, [2, 0]), (2.0, [0, 2]), (6.0, [2, 0]), (6.0, [0, 2])].into_iter().enumerate()
    {
        claims.push(judge.moment(powers, t, bands.moments[k])?);
    }
    Ok(claims)
}

fn steps(judge: &Judge<'_>, run: &DensityRun, range: (f64, f64)) -> Claim {
    let reason = "the Courant rule follows the smallest smoothing length, which clumping drives down; \
                  the prototype took 2,199, the paper reports about 11,000 for its whole run";
    let claim = judge.lines.of("steps/t6", "steps to t = 6");
    claim.measured(run.work.steps as f64, range).because(reason)
}
