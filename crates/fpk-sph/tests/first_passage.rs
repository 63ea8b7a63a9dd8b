//! Rates of crossing and the bound on first passage that they give.

use fpk_sph::observables::OutcrossingBound;
use fpk_sph::systems::{LinearOscillator, LinearOscillatorParameters, Window};
use fpk_sph::{Config, DEFAULT_MOST_STEPS, Error, InitialLattice, Method, Simulation};
use sde_integrators::GaussianMixture;

#[test]
fn the_rate_of_crossing_of_a_gaussian_is_that_of_rice() {
    let oscillator = LinearOscillator::new(LinearOscillatorParameters {
        natural_frequency: 2.0,
        damping_ratio: 0.1,
        noise_intensity: 0.3,
        window: Window::Stationary,
    })
    .unwrap();
    let (variance_q, covariance, variance_v) = (0.04, 0.02, 0.09);
    let law =
        GaussianMixture::gaussian([0.0, 0.0], [[variance_q, covariance], [covariance, variance_v]])
            .unwrap();
    for method in [Method::FlowMapFit, Method::LogDensityFit] {
        let config = Config {
            method,
            lattice: InitialLattice::box_of(41),
            reference_period: std::f64::consts::PI,
            most_steps: DEFAULT_MOST_STEPS,
        };
        let simulation = Simulation::new(oscillator.clone(), &law, &config).unwrap();
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
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{method:?} {threshold}: {found:e} {expected:e}"
            );
        }
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
