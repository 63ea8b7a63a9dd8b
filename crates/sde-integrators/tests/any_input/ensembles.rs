//! Ensembles by every method, and their maxima.

use proptest::prelude::*;
use sde_integrators::{
    Between, DiagonalNoise, EnsembleConfig, EulerMaruyama, GaussianComponent, GaussianMixture,
    Heun, Integrator, Milstein, Observable, Response, SemiImplicitEuler, Shark, Side, Sra3, Sriw1,
    StochasticTheta, StrangOscillator, StratonovichForm, maxima, simulate,
};

use super::drawn::{Cubic, count, cubic, is_told, number};

/// Ensembles up to this many steps of a path are followed.
const MOST_STEPS: f64 = 100.0;
/// Ensembles beyond this must be refused.
const TOO_MANY_STEPS: f64 = 1e16;

fn config() -> impl Strategy<Value = EnsembleConfig> {
    let times = prop_oneof![
        3 => number().prop_map(|t| vec![t]),
        1 => prop::collection::vec(number(), 0..4),
    ];
    (any::<u64>(), 0_u64..12, number(), times)
        .prop_map(|(seed, n_paths, dt, times)| EnsembleConfig { seed, n_paths, dt, times })
        .prop_filter("steps that are taken, and only slow", |config| {
            let last = config.times.iter().copied().fold(0.0, f64::max);
            !(MOST_STEPS..TOO_MANY_STEPS).contains(&(last / config.dt))
        })
}

fn law() -> impl Strategy<Value = Vec<GaussianComponent<2>>> {
    let weight = prop_oneof![2 => Just(0.5), 1 => Just(1.0), 1 => number()];
    let pair = || prop::array::uniform2(number());
    let covariance = prop_oneof![
        2 => pair().prop_map(|[a, b]| [[a, 0.0], [0.0, b]]),
        1 => prop::array::uniform2(pair()),
    ];
    let component = (weight, pair(), covariance)
        .prop_map(|(weight, mean, covariance)| GaussianComponent { weight, mean, covariance });
    prop::collection::vec(component, 0..3)
}

/// An ensemble by a method, if there is one.
fn follow<S, I, const M: usize>(
    system: &S,
    method: &I,
    law: &GaussianMixture<2>,
    config: &EnsembleConfig,
) -> Result<(), TestCaseError>
where
    S: Sync,
    I: Integrator<S, 2, M>,
{
    let observables = [
        Observable::Mean(&|_, x: &[f64; 2]| x[0]),
        Observable::Mean(&|_, x: &[f64; 2]| x[1] * x[1]),
        Observable::Probability(&|_, x: &[f64; 2]| x[0] > 0.0),
    ];
    if let Ok(ensemble) = simulate::<S, I, _, 2, M>(system, method, law, config, &observables) {
        for estimate in ensemble.estimates.iter().flatten() {
            prop_assert!(is_told(estimate), "{estimate:?}");
        }
    }
    Ok(())
}

/// A system, an initial distribution, a configuration and theta.
type Ensemble = (Cubic, Vec<GaussianComponent<2>>, EnsembleConfig, f64);

pub(crate) fn ensemble() -> impl Strategy<Value = Ensemble> {
    (cubic(), law(), config(), number())
}

pub(crate) fn is_followed_by_every_method(
    (system, law, config, theta): Ensemble,
) -> Result<(), TestCaseError> {
    let Ok(law) = GaussianMixture::mixture(&law) else { return Ok(()) };
    follow::<_, _, 1>(&system, &EulerMaruyama, &law, &config)?;
    follow::<_, _, 1>(&system, &Heun, &law, &config)?;
    follow::<_, _, 1>(&system, &Sra3, &law, &config)?;
    follow::<_, _, 1>(&system, &Shark, &law, &config)?;
    if let Ok(method) = StochasticTheta::new(theta) {
        follow::<_, _, 1>(&system, &method, &law, &config)?;
    }
    follow::<_, _, 1>(&system, &SemiImplicitEuler, &law, &config)?;
    follow::<_, _, 1>(&system, &StrangOscillator, &law, &config)?;
    follow::<_, _, 2>(&DiagonalNoise(system), &Milstein, &law, &config)?;
    follow::<_, _, 2>(&DiagonalNoise(system), &Sriw1, &law, &config)?;
    follow::<_, _, 2>(&StratonovichForm(system), &Heun, &law, &config)
}

/// What is looked at of an ensemble: component and side, the velocity of a cubic, and the intensity of a bridge or the frequency of an
/// arc.
type Watched = (Ensemble, (usize, bool), usize, f64);

pub(crate) fn watched() -> impl Strategy<Value = Watched> {
    let component = || prop_oneof![4 => 0_usize..2, 1 => count()];
    (ensemble(), (component(), any::<bool>()), component(), number())
}

pub(crate) fn has_maxima(
    ((system, law, config, ..), (component, is_above), velocity, value): Watched,
) -> Result<(), TestCaseError> {
    let Ok(law) = GaussianMixture::mixture(&law) else { return Ok(()) };
    let side = if is_above { Side::Above } else { Side::Magnitude };
    let intensity = |_: f64, x: &[f64]| value * (1.0 + x[0]);
    let ways = [
        Between::Endpoints,
        Between::BrownianBridge { intensity: &intensity },
        Between::CubicHermite { velocity },
        Between::RotationArc { natural_frequency: value },
    ];
    let mut lowest = Vec::new();
    for between in ways {
        let response = Response { component, side, between };
        let found = maxima::<_, _, _, 2, 1>(&system, &Heun, &law, &config, &response);
        let Ok(samples) = found else { continue };
        prop_assert_eq!(samples.len(), config.times.len());
        let medians: Vec<f64> = samples
            .iter()
            .flat_map(|samples| samples.quantile(0.5))
            .map(|estimate| estimate.value)
            .collect();
        prop_assert!(medians.iter().all(|median| median.is_finite()));
        // The ends of steps are part of every path.
        if matches!(between, Between::Endpoints) {
            lowest = medians;
        } else {
            prop_assert!(medians.iter().zip(&lowest).all(|(median, lowest)| median >= lowest));
        }
    }
    Ok(())
}
