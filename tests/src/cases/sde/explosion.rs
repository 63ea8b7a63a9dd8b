//! Where Euler-Maruyama explodes on `dX = -X^3 dt + sigma dB`, and how the library says so.

use reference_problems::sde::problems::Cubic;
use reference_problems::sde::reference::Explosion as Survey;
use sde_integrators::{
    EnsembleConfig, EulerMaruyama, Increment, Integrator, Noise, Observable, SimdLevel,
    StochasticTheta, Study,
};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/explosion",
    title: "explosion of Euler-Maruyama on -X^3: the edge sqrt(2/h) without noise, fractions of paths with noise",
    source: "derived/sde/explosion.json, an independent code with 10,000 paths",
    cost: Profile::Default,
    run: Together(run),
};

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = edge_claims(context)?;
    let survey = Survey::read()?;
    for (sigma, dt, published) in survey.rows {
        let config =
            EnsembleConfig { seed: 41, n_paths: survey.paths, dt, times: vec![survey.end] };
        let study = Study {
            name: "cubic",
            system: &Cubic { intensity: sigma },
            integrator: &EulerMaruyama,
            law: &[0.0],
            config: &config,
            observables: &[Observable::Mean(&|_, x| x[0])],
            level: SimdLevel::best(),
        };
        let fraction = study.run::<1>()?.n_failed as f64 / survey.paths as f64;
        // For none or all of n paths the rule of three replaces three standard errors.
        let error = |p: f64| {
            let n = survey.paths as f64;
            if p * (1.0 - p) > 0.0 { (p * (1.0 - p) / n).sqrt() } else { 1.0 / n }
        };
        let reason = "two independent samples of 10,000 paths";
        let quantity = "fraction of paths that fail";
        let method = "Euler-Maruyama, 10,000 paths from 0, T = 20; the independent code counts those beyond 1e10";
        let value = Measured::sampled(fraction, error(fraction));
        let reference = Reference::uncertain(published, error(published));
        let subject = context.subject(format!("fraction/sigma-{sigma}/h-{dt}"), quantity, method);
        claims.push(subject.absolute(value, reference).monte_carlo(0.0).because(reason));
    }
    claims.push(survivors_claim(context)?);
    Ok(claims)
}

/// Without noise `|x|` grows where `|1 - h x^2| > 1`: from 0.99 of the edge the state decays, from 1.01 it leaves.
fn edge_claims(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for dt in [0.2_f64, 0.05, 0.005] {
        for (share, stays) in [(0.99, true), (1.01, false)] {
            let mut x = [share * (2.0 / dt).sqrt()];
            for _ in 0..1000 {
                EulerMaruyama.step(
                    &Cubic { intensity: 0.0 },
                    0.0,
                    dt,
                    &Increment::ZERO,
                    &mut x,
                    &mut (),
                )?;
            }
            let quantity = "the path is finite after 1000 steps (1 yes, 0 no)";
            let method = "Euler-Maruyama without noise, start in units of sqrt(2/h)";
            let value = f64::from(u8::from(x[0].is_finite()));
            let reference = f64::from(u8::from(stays));
            let subject = context.subject(format!("edge/h-{dt}/start-{share}"), quantity, method);
            claims.push(subject.absolute(value, reference).within(0.0).because("yes or no"));
        }
    }
    Ok(claims)
}

/// At the step where every path of Euler-Maruyama explodes, backward Euler loses none.
fn survivors_claim(context: &Context<'_>) -> CaseResult<Claim> {
    let (system, dt) = (Cubic { intensity: 8.0 }, 0.1);
    let noise = Noise::new(44);
    let (mut lost_by_implicit, mut kept_by_explicit) = (0_u32, 0_u32);
    for realisation in 0..200 {
        let mut path = noise.path::<1>(realisation);
        let (mut implicit, mut explicit) = ([0.0], [0.0]);
        for _ in 0..200 {
            let dw = path.next_increment(dt);
            StochasticTheta::BACKWARD_EULER.step(&system, 0.0, dt, &dw, &mut implicit, &mut ())?;
            EulerMaruyama.step(&system, 0.0, dt, &dw, &mut explicit, &mut ())?;
        }
        lost_by_implicit += u32::from(!implicit[0].is_finite());
        kept_by_explicit += u32::from(explicit[0].is_finite());
    }
    let quantity = "paths lost by backward Euler, plus those that Euler-Maruyama keeps";
    let subject = context.subject("survivors", quantity, "sigma 8, h 0.1, 200 paths");
    Ok(subject.bounded(f64::from(lost_by_implicit + kept_by_explicit), 0.0).because("a count"))
}
