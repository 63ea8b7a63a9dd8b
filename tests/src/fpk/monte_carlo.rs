//! The rival: Monte Carlo on the same system and initial law.

use cpu_time::ProcessTime;
use sde_integrators::{
    EnsembleConfig, Error, Estimate, EulerMaruyama, GaussianMixture, Integrator, Observable, Sde,
    SecondOrder, SemiImplicitEuler, StrangOscillator, simulate,
};

use super::density::Asked;
use super::scene::{IntegratorScene, System};

/// What is sampled, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    /// Number of paths.
    pub paths: u64,
    /// Longest step.
    pub step: f64,
    /// How a path is stepped.
    pub integrator: IntegratorScene,
    /// Seed.
    pub seed: u64,
}

/// What was observed at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledRow {
    /// The time.
    pub t: f64,
    /// Raw moments, in the order asked.
    pub moments: Vec<Estimate>,
    /// `P(|q| > T)`, in the order of the thresholds.
    pub exceedances: Vec<Estimate>,
}

/// An ensemble.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledRun {
    /// One row per time.
    pub rows: Vec<SampledRow>,
    /// Steps of all paths.
    pub path_steps: u128,
    /// CPU time (s).
    pub cpu_seconds: f64,
}

impl SampledRun {
    /// The row of a time that was asked.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<&SampledRow> {
        self.rows.iter().find(|row| (row.t - t).abs() < 1e-9)
    }
}

impl IntegratorScene {
    /// Its name for the reader.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::EulerMaruyama => "forward Euler",
            Self::SemiImplicitEuler => "semi-implicit Euler",
            Self::StrangOscillator => "Strang",
        }
    }
}

/// Samples a built-in system; [`Asked::cells`] has no meaning here.
///
/// # Errors
/// Those of the ensemble: bad numbers, or a path that is no longer finite.
pub fn run(
    system: &System,
    law: &GaussianMixture<2>,
    sampling: &Sampling,
    asked: &Asked,
) -> Result<SampledRun, Error> {
    match system {
        System::Linear(system) => by_integrator(system, law, sampling, asked),
        System::Damper(system) => by_integrator(system, law, sampling, asked),
    }
}

fn by_integrator<S: Sde<2, 1> + SecondOrder<1, 1>>(
    system: &S,
    law: &GaussianMixture<2>,
    sampling: &Sampling,
    asked: &Asked,
) -> Result<SampledRun, Error> {
    match sampling.integrator {
        IntegratorScene::EulerMaruyama => sample(system, &EulerMaruyama, law, sampling, asked),
        IntegratorScene::SemiImplicitEuler => {
            sample(system, &SemiImplicitEuler, law, sampling, asked)
        }
        IntegratorScene::StrangOscillator => {
            sample(system, &StrangOscillator, law, sampling, asked)
        }
    }
}

fn sample<S: Sync, I: Integrator<S, 2, 1>>(
    system: &S,
    integrator: &I,
    law: &GaussianMixture<2>,
    sampling: &Sampling,
    asked: &Asked,
) -> Result<SampledRun, Error> {
    let Asked { times, powers, thresholds, .. } = asked;
    let monomials: Vec<_> =
        powers.iter().map(|&powers| move |_: f64, x: &[f64; 2]| monomial(powers, x)).collect();
    let events: Vec<_> = thresholds
        .iter()
        .map(|&threshold| move |_: f64, x: &[f64; 2]| x[0].abs() > threshold)
        .collect();
    let mut observables: Vec<Observable<'_, 2>> = Vec::new();
    observables.extend(monomials.iter().map(|f| Observable::Mean(f)));
    observables.extend(events.iter().map(|event| Observable::Probability(event)));
    let config = EnsembleConfig {
        seed: sampling.seed,
        n_paths: sampling.paths,
        dt: sampling.step,
        times: times.clone(),
    };
    let start = ProcessTime::now();
    let ensemble = simulate(system, integrator, law, &config, &observables)?;
    let cpu_seconds = start.elapsed().as_secs_f64();
    let rows = ensemble
        .times
        .iter()
        .zip(&ensemble.estimates)
        .map(|(&t, estimates)| SampledRow {
            t,
            moments: estimates[..powers.len()].to_vec(),
            exceedances: estimates[powers.len()..].to_vec(),
        })
        .collect();
    Ok(SampledRun { rows, path_steps: ensemble.path_steps, cpu_seconds })
}

fn monomial([a, b]: [u32; 2], x: &[f64; 2]) -> f64 {
    let power = |base: f64, exponent: u32| (0..exponent).fold(1.0, |product, _| product * base);
    power(x[0], a) * power(x[1], b)
}
