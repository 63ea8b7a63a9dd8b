//! First passage: rates of crossing with the bound that they give, and the absorbing boundary.

use fpk_sph::observables::{FirstPassage, OutcrossingBound};
use fpk_sph::{Error, InitialLattice, Simulation};
use sde_integrators::{
    Additive, Between, EnsembleConfig, GaussianMixture, Response, Sde, Side, StrangOscillator,
    maxima,
};
use vibrating_systems::LinearOscillator;

use crate::fixtures::{config, oscillator};

#[test]
fn the_rate_of_crossing_of_a_gaussian_is_that_of_rice() {
    let (variance_q, covariance, variance_v) = (0.04, 0.02, 0.09);
    let law =
        GaussianMixture::gaussian([0.0, 0.0], [[variance_q, covariance], [covariance, variance_v]])
            .unwrap();
    let config = config(InitialLattice::box_of(41), std::f64::consts::PI);
    let simulation = Simulation::new(oscillator(2.0, 0.1, 0.3), &law, &config).unwrap();
    let cells = simulation.cell_integral().unwrap();
    for threshold in [0.0, 0.3, 0.6, 1.0] {
        let found = cells.crossing_rate(|x| x[0], |x| x[1], threshold).unwrap();
        // At q = T the velocity is Gaussian with this mean and deviation; E[max(v, 0)] = s phi(m/s) + m Phi(m/s).
        let mean = covariance / variance_q * threshold;
        let deviation = (variance_v - covariance * covariance / variance_q).sqrt();
        let marginal = (-0.5 * threshold * threshold / variance_q).exp()
            / (std::f64::consts::TAU * variance_q).sqrt();
        let n = 20_000;
        let expected: f64 = (0..n)
            .map(|k| (f64::from(k) + 0.5) / f64::from(n) * 10.0)
            .map(|v| {
                let z = (v - mean) / deviation;
                v * (-0.5 * z * z).exp() / deviation / std::f64::consts::TAU.sqrt()
            })
            .sum::<f64>()
            * 10.0
            / f64::from(n)
            * marginal;
        // The density is replaced by a mean over a hat of 0.025 standard deviations on either side, whose variance is
        // 1e-4: half of it times 5^2 at 5 standard deviations is 1.3e-3. The positive part has a corner besides.
        assert!((found / expected - 1.0).abs() < 2e-3, "{threshold}: {found:e} {expected:e}");
    }
}

#[test]
fn the_bound_adds_what_was_beyond_at_the_start_and_every_crossing() {
    let mut bound = OutcrossingBound::new(0.01).unwrap();
    for (time, rate) in [(0.0, 0.0), (1.0, 0.2), (3.0, 0.1)] {
        bound.record(time, rate).unwrap();
    }
    assert!((bound.expected_crossings() - 0.4).abs() < 1e-15);
    assert!((bound.probability() - 0.41).abs() < 1e-15);
    assert!(matches!(bound.record(2.0, 0.1), Err(Error::TimeInThePast { .. })));
    assert!(matches!(bound.record(4.0, f64::NAN), Err(Error::NotFinite { .. })));
    assert!(matches!(bound.record(4.0, -1.0), Err(Error::Negative { .. })));
    assert!((bound.probability() - 0.41).abs() < 1e-15, "what was refused leaves no trace");
}

/// `dX = 0.6 dB`: the noise acts on the demand itself.
#[derive(Debug)]
struct BrownianMotion;

const INTENSITY: f64 = 0.6;

impl Sde<1, 1> for BrownianMotion {
    type Noise = Additive;

    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[INTENSITY]]
    }
}

/// `P(max X > b)` from a normal start, by the reflection principle: `P(X_0 > b) + E[2 P(X_t > b | X_0); X_0 < b]`.
fn reflected(deviation: f64, b: f64, t: f64) -> f64 {
    let upper_tail = |z: f64| {
        let n = 4_000;
        let step = 12.0 / f64::from(n);
        let density = |u: f64| (-0.5 * u * u).exp() / std::f64::consts::TAU.sqrt();
        (0..n).map(|k| density(z + (f64::from(k) + 0.5) * step)).sum::<f64>() * step
    };
    let n = 2_000;
    let step = 16.0 / f64::from(n);
    (0..n)
        .map(|k| -8.0 + (f64::from(k) + 0.5) * step)
        .map(|z| {
            let weight = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * step;
            let below = b - deviation * z;
            let passed =
                if below <= 0.0 { 1.0 } else { 2.0 * upper_tail(below / (INTENSITY * t.sqrt())) };
            weight * passed
        })
        .sum()
}

#[test]
fn noise_on_the_demand_is_absorbed_as_the_reflection_principle_says() {
    let (deviation, thresholds) = (0.2, [0.6, 1.0, 1.5]);
    let law = GaussianMixture::gaussian([0.0], [[deviation * deviation]]).unwrap();
    let errors = [61, 121].map(|count| {
        let config = config(InitialLattice::box_of(count), 1.0);
        let mut simulation = Simulation::new(BrownianMotion, &law, &config).unwrap();
        let mut passage = FirstPassage::new(&simulation, |x| x[0], &thresholds).unwrap();
        passage.advance_to(&mut simulation, 1.0).unwrap();
        let mut errors = [0.0; 3];
        for (k, threshold) in thresholds.into_iter().enumerate() {
            let expected = reflected(deviation, threshold, 1.0);
            errors[k] = passage.probabilities()[k] / expected - 1.0;
        }
        errors
    });
    // A fit of second order to where the threshold cuts, and a splitting in time of which the parts of an exchange leave
    // little: seen within 0.6 % at a spacing of 0.2 deviations, within 0.3 % at 0.1.
    assert!(errors[0].iter().all(|error| error.abs() < 0.01), "{errors:?}");
    assert!(errors[1].iter().all(|error| error.abs() < 0.005), "{errors:?}");
}

fn system() -> LinearOscillator {
    oscillator(2.0, 0.05, 0.5)
}

fn start() -> GaussianMixture<2> {
    GaussianMixture::independent([0.0, 0.0], [0.2, 0.4]).unwrap()
}

fn simulation(count: usize) -> Simulation<LinearOscillator, 2, 1> {
    let config = config(InitialLattice::box_of(count), std::f64::consts::PI);
    Simulation::new(system(), &start(), &config).unwrap()
}

fn watched(count: usize, thresholds: &[f64], end: f64) -> Vec<f64> {
    let mut simulation = simulation(count);
    let mut passage = FirstPassage::new(&simulation, |x| x[0].abs(), thresholds).unwrap();
    let mut last = passage.probabilities().to_vec();
    while simulation.time() < end {
        let _report = simulation.step().unwrap();
        passage.record(&simulation).unwrap();
        for (k, (now, before)) in passage.probabilities().iter().zip(&last).enumerate() {
            assert!(now >= before, "what is absorbed stays absorbed");
            let w = passage.survival(k).unwrap();
            assert!(w.iter().all(|w| (0.0..=1.0 + 1e-12).contains(w)), "no overshoot");
            let surviving: f64 = w.iter().zip(simulation.masses()).map(|(w, mu)| w * mu).sum();
            // Roundoff of a sum of some thousand terms over some hundred steps.
            assert!((surviving + now - simulation.total_mass()).abs() < 1e-12);
        }
        last.copy_from_slice(passage.probabilities());
    }
    assert!(last.windows(2).all(|pair| pair[1] <= pair[0]), "{last:?}");
    last
}

#[test]
fn an_oscillator_passes_its_threshold_as_often_as_its_paths() {
    let (thresholds, end) = ([0.8, 1.2], 4.0);
    let found = watched(41, &thresholds, end);
    let config = EnsembleConfig { seed: 11, n_paths: 40_000, dt: 0.02, times: vec![end] };
    let response = Response {
        component: 0,
        side: Side::Magnitude,
        between: Between::CubicHermite { velocity: 1 },
    };
    let maxima = maxima(&system(), &StrangOscillator, &start(), &config, &response).unwrap();
    for (threshold, found) in thresholds.into_iter().zip(found) {
        let paths = maxima[0].exceedance(threshold).unwrap();
        let error = paths.standard_error().unwrap();
        // Spacing of 0.3 deviations: 1.5 % seen here; and what the paths know.
        let tolerance = 0.03 * paths.value + 4.0 * error;
        assert!((found - paths.value).abs() < tolerance, "{threshold}: {found} {paths:?}");
    }
}

#[test]
fn a_watch_refuses_what_it_cannot_judge() {
    let mut watched = simulation(21);
    let demand = |x: &[f64; 2]| x[0];
    let message = |error: Error| error.to_string();
    assert_eq!(
        message(FirstPassage::new(&watched, demand, &[]).unwrap_err()),
        "thresholds has 0 rows; at least 1 are needed"
    );
    assert_eq!(
        message(FirstPassage::new(&watched, demand, &[f64::NAN]).unwrap_err()),
        "threshold is NaN; it must be finite"
    );
    assert_eq!(
        message(FirstPassage::new(&watched, |x: &[f64; 2]| x[0].ln(), &[0.0]).unwrap_err()),
        "demand is NaN; it must be finite"
    );
    let mut passage = FirstPassage::new(&watched, demand, &[0.5]).unwrap();
    let _report = watched.step().unwrap();
    passage.record(&watched).unwrap();
    let recorded = passage.probabilities().to_vec();
    passage.record(&watched).unwrap();
    assert_eq!(passage.probabilities(), recorded, "a step counts once");
    let _reports = [watched.step().unwrap(), watched.step().unwrap()];
    assert_eq!(
        message(passage.record(&watched).unwrap_err()),
        "the simulation has taken 3 steps, the last one recorded is 1; every step must be recorded"
    );
    assert_eq!(
        message(passage.record(&simulation(15)).unwrap_err()),
        "the simulation holds 225 particles, the watched one 441"
    );
    let mut late = FirstPassage::new(&watched, demand, &[0.5]).unwrap();
    assert!(matches!(late.advance_to(&mut watched, 0.0).unwrap_err(), Error::TimeInThePast { .. }));
}
