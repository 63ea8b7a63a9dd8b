//! Where Euler-Maruyama explodes on `dX = -X^3 dt + sigma dB`, and how the library says so.

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{
    EnsembleConfig, Error, EulerMaruyama, Increment, Integrator, Observable, Sra1, StepError,
    StochasticTheta, TamedEuler, simulate,
};
use work_precision::problems::sde::problems::Cubic;
use work_precision::problems::sde::reference::Explosion as Survey;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;
use crate::sde::explosion::departures;

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
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "2000 at most")]
        let n_steps = (survey.end / dt).round() as u64;
        let system = Cubic { intensity: sigma };
        let left = departures(system, (41, survey.paths), (dt, n_steps), 1e10)?.len();
        let fraction = left as f64 / survey.paths as f64;
        // For none or all of n paths the rule of three replaces three standard errors.
        let error = |p: f64| {
            let n = survey.paths as f64;
            if p * (1.0 - p) > 0.0 { (p * (1.0 - p) / n).sqrt() } else { 1.0 / n }
        };
        let subject = context.subject(
            &format!("fraction/sigma-{sigma}/h-{dt}"),
            "fraction of paths beyond 1e10",
            "",
            "Euler-Maruyama, 10,000 paths from 0, T = 20",
        );
        let reason = "two independent samples of 10,000 paths";
        let criterion = Criterion::MonteCarlo { bias_bound: 0.0, reason };
        let measured = Measured::sampled(fraction, error(fraction));
        let reference = Reference::uncertain(published, error(published));
        claims.push(Claim::judge(subject, ErrorKind::Absolute, measured, reference, criterion));
    }
    claims.extend(error_claims(context)?);
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

/// The ensemble ends with the error of the lowest path that leaves: its number, its step and its time.
fn error_claims(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (dt, seed) = (0.1, 43);
    let system = Cubic { intensity: 4.0 };
    let left = departures(system, (seed, 64), (dt, 200), f64::MAX)?;
    let first = left.first().ok_or("no path leaves")?;
    let config = EnsembleConfig { seed, n_paths: 64, dt, times: vec![20.0] };
    let observables = [Observable::Mean(&|_, x: &[f64; 1]| x[0])];
    let Err(error) = simulate(&system, &EulerMaruyama, &[0.0], &config, &observables) else {
        return Err("an ensemble with exploding paths gave a result".into());
    };
    let Error::NonFiniteState { realisation, steps, t, .. } = error else {
        return Err(format!("not the error expected: {error}").into());
    };
    let rows = [
        ("path", "", realisation as f64, first.realisation as f64, 0.0),
        ("step", "", steps as f64, first.steps as f64, 0.0),
        ("time", "1", t, first.steps as f64 * dt, 1e-12),
    ];
    Ok(rows
        .into_iter()
        .map(|(what, unit, named, expected, tolerance)| {
            let subject = context.subject(
                &format!("error/{what}"),
                &format!("{what} named by the error"),
                unit,
                "simulate, Euler-Maruyama, sigma 4, h 0.1",
            );
            let reason = "roundoff: of the time, 90 additions of a step; path and step by the same noise, followed by hand";
            let criterion = Criterion::Within { tolerance, reason };
            let (named, expected) = (Measured::exact(named), Reference::exact(expected));
            Claim::judge(subject, ErrorKind::Absolute, named, expected, criterion)
        })
        .collect())
}

/// At the step where every path of Euler-Maruyama explodes, tamed and backward Euler lose none; SRA1 loses all too.
fn survivors_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
    let (system, dt) = (Cubic { intensity: 8.0 }, 0.1);
    let noise = sde_integrators::Noise::new(44);
    let (mut lost, mut n) = ([0_u32; 3], 0_u32);
    for realisation in 0..200 {
        let mut path = noise.path::<1>(realisation);
        let mut x = [[0.0]; 3];
        for _ in 0..200 {
            let dw = path.next_increment(dt);
            TamedEuler.step(&system, 0.0, dt, &dw, &mut x[0], &mut ())?;
            StochasticTheta::BACKWARD_EULER.step(&system, 0.0, dt, &dw, &mut x[1], &mut ())?;
            if x[2][0].is_finite() {
                Sra1.step(&system, 0.0, dt, &dw, &mut x[2], &mut ())?;
            }
        }
        for (lost, x) in lost.iter_mut().zip(x) {
            *lost += u32::from(!x[0].is_finite());
        }
        n += 1;
    }
    let subject = context.subject(
        "survivors",
        "paths lost by tamed and backward Euler, plus those that SRA1 keeps",
        "",
        "sigma 8, h 0.1, 200 paths",
    );
    let wrong = lost[0] + lost[1] + (n - lost[2]);
    let criterion = Criterion::Within { tolerance: 0.0, reason: "a count" };
    let (measured, zero) = (Measured::exact(f64::from(wrong)), Reference::exact(0.0));
    let claim = Claim::judge(subject, ErrorKind::Absolute, measured, zero, criterion);
    Ok::<_, StepError>(claim).map_err(CaseError::from)
}
