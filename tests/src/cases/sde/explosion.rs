//! Where Euler-Maruyama explodes on `dX = -X^3 dt + sigma dB`, and how the library says so.

use reference_problems::sde::problems::Cubic;
use reference_problems::sde::reference::Explosion as Survey;
use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{
    EnsembleConfig, EulerMaruyama, Increment, Integrator, Noise, Observable, SimdLevel,
    StochasticTheta, Study,
};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/explosion",
    title: "explosion of Euler-Maruyama on -X^3: the edge sqrt(2/h) without noise, fractions of paths with noise",
    source: "derived/sde/explosion.json, an independent code with 10,000 paths",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
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
        let subject = context.subject(
            &format!("fraction/sigma-{sigma}/h-{dt}"),
            "fraction of paths that fail",
            "",
            "Euler-Maruyama, 10,000 paths from 0, T = 20; the independent code counts those beyond 1e10",
        );
        let reason = "two independent samples of 10,000 paths";
        let criterion = Criterion::MonteCarlo { bias_bound: 0.0, reason };
        let measured = Measured::sampled(fraction, error(fraction));
        let reference = Reference::uncertain(published, error(published));
        claims.push(Claim::judge(subject, ErrorKind::Absolute, measured, reference, criterion));
    }
    claims.push(survivors_claim(context)?);
    Ok(claims)
}

/// Without noise `|x|` grows where `|1 - h x^2| > 1`: from 0.99 of the edge the state decays, from 1.01 it leaves.
fn edge_claims(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
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
            let subject = context.subject(
                &format!("edge/h-{dt}/start-{share}"),
                "the path is finite after 1000 steps (1 yes, 0 no)",
                "",
                "Euler-Maruyama without noise, start in units of sqrt(2/h)",
            );
            let finite = Measured::exact(f64::from(u8::from(x[0].is_finite())));
            let expected = Reference::exact(f64::from(u8::from(stays)));
            let criterion = Criterion::Within { tolerance: 0.0, reason: "yes or no" };
            claims.push(Claim::judge(subject, ErrorKind::Absolute, finite, expected, criterion));
        }
    }
    Ok(claims)
}

/// At the step where every path of Euler-Maruyama explodes, backward Euler loses none.
fn survivors_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
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
    let subject = context.subject(
        "survivors",
        "paths lost by backward Euler, plus those that Euler-Maruyama keeps",
        "",
        "sigma 8, h 0.1, 200 paths",
    );
    let criterion = Criterion::Within { tolerance: 0.0, reason: "a count" };
    let wrong = Measured::exact(f64::from(lost_by_implicit + kept_by_explicit));
    Ok(Claim::judge(subject, ErrorKind::Absolute, wrong, Reference::exact(0.0), criterion))
}
