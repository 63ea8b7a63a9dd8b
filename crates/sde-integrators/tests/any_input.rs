//! Whatever numbers come in, laws, factors, methods and first steps end in a result or a typed error: no panic, no hang, no memory
//! beyond [`MOST_BYTES`], no NaN in what is told. `PROPTEST_CASES` says how many are tried.

#[path = "../../lanes/tests/shared/number.rs"]
mod any_number;

use std::alloc::System;

use cap::Cap;
use proptest::prelude::*;
use sde_integrators::{
    AdaptivePath, Additive, Baoab, Between, DenseFactor, DesignPoint, DiagonalFactor,
    DiagonalNoise, DiagonalSde, DrivenPath, EnsembleConfig, Estimate, EulerMaruyama, FieldPath,
    FieldSde, GaussianComponent, GaussianMixture, Heun, Integrator, LeimkuhlerMatthews,
    LinearTheta, LowRankFactor, Milstein, Noise, NoiseFactor, Observable, Response, Samples, Sde,
    SecondOrder, SemiImplicitEuler, Shark, Side, SkRock, SparseFactor, Sra1, Sra3, Sriw1,
    StepControl, StochasticTheta, StrangOscillator, StratonovichForm, SubsetConfig, TamedEuler,
    Uncertainty, design_point, importance_sampling, maxima, simulate, subset_simulation,
};

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Ensembles up to this many steps of a path are followed.
const MOST_STEPS: f64 = 100.0;
/// Ensembles beyond this must be refused.
const TOO_MANY_STEPS: f64 = 1e16;
/// Factors up to this many motions are used.
const MOST_MOTIONS: usize = 100;
/// Factors beyond this must be refused.
const TOO_MANY_MOTIONS: usize = 5_000_000_000;

/// Any double.
fn number() -> impl Strategy<Value = f64> {
    any_number::number(0.1..1.0, 8)
}

fn count() -> impl Strategy<Value = usize> {
    prop_oneof![8 => 0_usize..5, 1 => any::<usize>(), 1 => Just(1 << 32), 1 => Just(usize::MAX)]
}

fn numbers() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(number(), 0..10)
}

/// A cubic oscillator with any constants.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic {
    rates: [f64; 2],
    hardening: f64,
    force: f64,
    noise: [f64; 2],
}

impl Cubic {
    fn slope(&self, [x, v]: [f64; 2]) -> [f64; 2] {
        [v, self.force - self.rates[0] * x - self.rates[1] * v - self.hardening * x * x * x]
    }
}

impl Sde<2, 1> for Cubic {
    type Noise = Additive;

    fn drift(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        self.slope(*x)
    }

    fn noise(&self, _t: f64, _x: &[f64; 2]) -> [[f64; 1]; 2] {
        self.noise.map(|s| [s])
    }
}

impl DiagonalSde<2> for Cubic {
    fn drift(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        self.slope(*x)
    }

    fn intensity(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        [self.noise[0] * x[0], self.noise[1] * x[1]]
    }

    fn intensity_derivative(&self, _t: f64, _x: &[f64; 2]) -> [f64; 2] {
        self.noise
    }
}

impl SecondOrder<1, 1> for Cubic {
    fn natural_frequency(&self) -> [f64; 1] {
        [self.rates[0]]
    }

    fn linear_damping(&self) -> [f64; 1] {
        [self.rates[1]]
    }

    fn remaining_acceleration(&self, _t: f64, q: &[f64; 1], _v: &[f64; 1]) -> [f64; 1] {
        [self.force - self.hardening * q[0] * q[0] * q[0]]
    }

    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; 1], v: &mut [f64; 1]) {
        v[0] += dt * self.remaining_acceleration(t, q, v)[0];
    }

    fn noise_intensity(&self, _t: f64) -> [[f64; 1]; 1] {
        [[self.noise[0]]]
    }
}

fn cubic() -> impl Strategy<Value = Cubic> {
    let pair = || prop::array::uniform2(number());
    (pair(), number(), number(), pair()).prop_map(|(rates, hardening, force, noise)| Cubic {
        rates,
        hardening,
        force,
        noise,
    })
}

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

/// What is told is a number with an error that is one.
fn is_told(estimate: &Estimate) -> bool {
    let error = match estimate.uncertainty {
        Uncertainty::StandardError(error) | Uncertainty::Bound(error) => error,
        Uncertainty::Unknown => 0.0,
    };
    estimate.value.is_finite() && error.is_finite()
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

/// A field without a drift.
struct Noisy<F>(F);

impl<F: NoiseFactor> FieldSde for Noisy<F> {
    type Factor = F;

    fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) {
        for (drift, x) in drift.iter_mut().zip(x) {
            *drift = -x * x;
        }
    }

    fn factor(&self) -> &F {
        &self.0
    }
}

/// A few steps of a field, if it starts; a state is finite whatever happened.
fn step_field(
    factor: impl NoiseFactor,
    start: &[f64],
    (theta, operator, dt): (f64, &[f64], f64),
) -> Result<(), TestCaseError> {
    let (field, noise) = (Noisy(factor), Noise::new(1));
    if let Ok(mut path) = FieldPath::new(&field, &EulerMaruyama, &noise, 0, start.to_vec()) {
        let _ = path.step(dt).and_then(|()| path.step(dt));
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    if let Ok(operator) = DiagonalFactor::new(operator.to_vec())
        && let Ok(method) = LinearTheta::new(theta, operator)
        && let Ok(mut path) = FieldPath::new(&field, &method, &noise, 0, start.to_vec())
    {
        let _ = path.step(dt);
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    Ok(())
}

/// A system, a law, what is followed, theta and stages of the methods that have them.
type Ensemble = (Cubic, Vec<GaussianComponent<2>>, EnsembleConfig, f64, u64);

pub(crate) fn ensemble() -> impl Strategy<Value = Ensemble> {
    let stages = prop_oneof![8 => 1_u64..8, 1 => 1001_u64.., 1 => Just(0)];
    (cubic(), law(), config(), number(), stages)
}

pub(crate) fn is_followed_by_every_method(
    (system, law, config, theta, stages): Ensemble,
) -> Result<(), TestCaseError> {
    let Ok(law) = GaussianMixture::mixture(&law) else { return Ok(()) };
    follow::<_, _, 1>(&system, &EulerMaruyama, &law, &config)?;
    follow::<_, _, 1>(&system, &Heun, &law, &config)?;
    follow::<_, _, 1>(&system, &Sra1, &law, &config)?;
    follow::<_, _, 1>(&system, &Sra3, &law, &config)?;
    follow::<_, _, 1>(&system, &Shark, &law, &config)?;
    follow::<_, _, 1>(&system, &TamedEuler, &law, &config)?;
    follow::<_, _, 1>(&system, &LeimkuhlerMatthews, &law, &config)?;
    if let Ok(method) = StochasticTheta::new(theta) {
        follow::<_, _, 1>(&system, &method, &law, &config)?;
    }
    if let Ok(method) = SkRock::new(stages) {
        follow::<_, _, 1>(&system, &method, &law, &config)?;
    }
    follow::<_, _, 1>(&system, &SemiImplicitEuler, &law, &config)?;
    follow::<_, _, 1>(&system, &StrangOscillator, &law, &config)?;
    follow::<_, _, 1>(&system, &Baoab, &law, &config)?;
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
    let intensity = |_: f64, x: &[f64; 2]| value * (1.0 + x[0]);
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

/// A path and what of it is rare.
#[derive(Debug)]
pub(crate) struct Rare {
    system: Cubic,
    start: [f64; 2],
    dt: f64,
    n_steps: usize,
    /// Beside those that the path takes, as a rule none.
    more_normals: usize,
    /// Whether the response is a ratio, which need not be a number.
    is_ratio: bool,
    threshold: f64,
    /// In place of the one that is found.
    point: Option<Vec<f64>>,
    n_samples: u64,
    subset: SubsetConfig,
}

pub(crate) fn rare() -> impl Strategy<Value = Rare> {
    let more = prop_oneof![20 => Just(0), 1 => count()];
    let n_samples = prop_oneof![9 => 100_usize..120, 1 => count()];
    let n_runs = prop_oneof![9 => 0_u64..4, 1 => any::<u64>()]
        .prop_filter("runs that are made, and only slow", |n| !(4..=1 << 16).contains(n));
    let correlation = prop_oneof![4 => 0.1..0.9, 1 => number()];
    let subset = (n_samples, correlation, n_runs).prop_map(|(n_samples, correlation, n_runs)| {
        SubsetConfig { n_samples, correlation, n_runs }
    });
    (
        (cubic(), prop::array::uniform2(number()), number(), 0_usize..4),
        (more, any::<bool>(), number()),
        (prop::option::weighted(0.2, numbers()), 0_u64..100, subset),
    )
        .prop_map(
            |(
                (system, start, dt, n_steps),
                (more_normals, is_ratio, threshold),
                (point, n_samples, subset),
            )| Rare {
                system,
                start,
                dt,
                n_steps,
                more_normals,
                is_ratio,
                threshold,
                point,
                n_samples,
                subset,
            },
        )
}

/// A probability with an error, or one of which no error is known.
fn is_probability(estimate: &Estimate, largest: f64) -> bool {
    is_told(estimate)
        && (0.0..=largest).contains(&estimate.value)
        && (estimate.value > 0.0 || estimate.uncertainty == Uncertainty::Unknown)
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn estimates_the_rare(rare: Rare) -> Result<(), TestCaseError> {
    let Rare { system, start, dt, n_steps, threshold, .. } = rare;
    let path = DrivenPath { system: &system, integrator: &Heun, start, dt, n_steps };
    let n_normals = path.n_normals::<1>().saturating_add(rare.more_normals);
    let response = |normals: &[f64]| {
        let [x, v] = path.run::<1>(normals, |_, _, _| ())?;
        Ok(if rare.is_ratio { x / v } else { x })
    };
    let noise = Noise::new(1);
    let given = rare.point.map(|normals| DesignPoint {
        reliability_index: normals.iter().map(|u| u * u).sum::<f64>().sqrt(),
        normals,
        iterations: 0,
    });
    let point = match given {
        Some(point) => Some(point),
        None => design_point(&response, n_normals, threshold).ok(),
    };
    if let Some(point) = point
        && let Ok(estimate) =
            importance_sampling(&response, threshold, &point, &noise, rare.n_samples)
    {
        prop_assert!(is_probability(&estimate, f64::MAX), "{estimate:?}");
    }
    let subset = subset_simulation(&response, n_normals, threshold, &noise, &rare.subset);
    if let Ok(estimate) = subset {
        prop_assert!(is_probability(&estimate, 1.0), "{estimate:?}");
    }
    Ok(())
}

/// A system, its start, the control of its step, seed and realisation.
type Path = (Cubic, [f64; 2], StepControl, (u64, u64));

pub(crate) fn adaptive_path() -> impl Strategy<Value = Path> {
    let halvings = prop_oneof![6 => 0_u32..20, 1 => any::<u32>()];
    let control = (number(), number(), number(), halvings).prop_map(
        |(longest, absolute, relative, halvings)| StepControl {
            longest,
            absolute,
            relative,
            halvings,
        },
    );
    (cubic(), prop::array::uniform2(number()), control, any::<(u64, u64)>())
}

pub(crate) fn adapts(
    (system, start, control, (seed, realisation)): Path,
) -> Result<(), TestCaseError> {
    let noise = Noise::new(seed);
    if let Ok(mut path) = AdaptivePath::new(&system, &Sra1, &noise, realisation, start, &control) {
        let _ = path.step().and_then(|_| path.step());
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    let system = DiagonalNoise(system);
    let path = AdaptivePath::new(&system, &Milstein, &noise, realisation, start, &control);
    if let Ok(mut path) = path {
        let _ = path.step().and_then(|_| path.step());
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    Ok(())
}

/// Of the factors of a field, and of a method for it.
#[derive(Debug)]
pub(crate) struct Field {
    n: usize,
    motions: usize,
    values: Vec<f64>,
    start: Vec<f64>,
    operator: Vec<f64>,
    rows: Vec<usize>,
    columns: Vec<usize>,
    theta: f64,
    dt: f64,
}

pub(crate) fn field() -> impl Strategy<Value = Field> {
    let places = || prop::collection::vec(count(), 0..5);
    let parts = (
        (count(), count()),
        (numbers(), numbers(), numbers()),
        (places(), places()),
        (number(), number()),
    );
    parts.prop_map(|((n, motions), (values, start, operator), (rows, columns), (theta, dt))| {
        Field { n, motions, values, start, operator, rows, columns, theta, dt }
    })
}

impl Field {
    /// A start that fits, as a rule.
    fn start(&self, n: usize) -> Vec<f64> {
        if n < 10 {
            [self.start.as_slice(), &[0.5; 10]].concat()[..n].to_vec()
        } else {
            self.start.clone()
        }
    }

    fn step(&self, factor: impl NoiseFactor, n: usize) -> Result<(), TestCaseError> {
        step_field(factor, &self.start(n), (self.theta, &self.operator, self.dt))
    }
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn steps_by_every_factor(field: Field) -> Result<(), TestCaseError> {
    let Field { n, motions, values, rows, columns, .. } = &field;
    let (n, motions) = (*n, *motions);
    if let Ok(factor) = DiagonalFactor::new(values.clone()) {
        field.step(factor, values.len())?;
    }
    if let Ok(factor) = LowRankFactor::new(n, values.clone()) {
        field.step(factor, n)?;
    }
    if let Ok(factor) = DenseFactor::new(n, values) {
        field.step(factor, n)?;
    }
    let few = n.min(4);
    let identity: Vec<f64> =
        (0..few.pow(2)).map(|k| f64::from(u8::from(k % (few + 1) == 0))).collect();
    if let Ok(factor) = DenseFactor::new(few, &identity) {
        field.step(factor, few)?;
    }
    if !(MOST_MOTIONS..TOO_MANY_MOTIONS).contains(&motions) {
        let values = [values.as_slice(), &[0.5; 5]].concat()[..columns.len()].to_vec();
        for row_starts in [rows.clone(), (0..=columns.len()).collect()] {
            let factor = SparseFactor::new(motions, row_starts, columns.clone(), values.clone());
            if let Ok(factor) = factor {
                let n = factor.n_unknowns();
                field.step(factor, n)?;
            }
        }
    }
    Ok(())
}

/// Values, a level, a probability, hits and trials.
type Sample = (Vec<f64>, f64, f64, (u64, u64));

pub(crate) fn sample() -> impl Strategy<Value = Sample> {
    (numbers(), number(), number(), any::<(u64, u64)>())
}

pub(crate) fn tells_numbers(
    (values, level, probability, (hits, trials)): Sample,
) -> Result<(), TestCaseError> {
    if let Ok(samples) = Samples::new(values) {
        for estimate in [samples.exceedance(level), samples.quantile(probability)].iter().flatten()
        {
            prop_assert!(is_told(estimate), "{estimate:?}");
        }
    }
    if let Ok(estimate) = Estimate::probability(hits, trials) {
        prop_assert!(is_told(&estimate), "{estimate:?}");
    }
    Ok(())
}

proptest! {
    #[test]
    fn an_ensemble_is_followed_by_every_method_or_says_why_not(ensemble in ensemble()) {
        is_followed_by_every_method(ensemble)?;
    }

    #[test]
    fn an_adaptive_path_starts_or_says_why_not(path in adaptive_path()) {
        adapts(path)?;
    }

    #[test]
    fn a_field_starts_or_says_why_not(field in field()) {
        steps_by_every_factor(field)?;
    }

    #[test]
    fn a_sample_tells_numbers_or_says_why_not(sample in sample()) {
        tells_numbers(sample)?;
    }

    #[test]
    fn an_ensemble_has_maxima_or_says_why_not(watched in watched()) {
        has_maxima(watched)?;
    }

    #[test]
    fn the_rare_is_estimated_or_says_why_not(rare in rare()) {
        estimates_the_rare(rare)?;
    }
}
