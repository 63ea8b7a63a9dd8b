//! Subset simulation of one time.

use random_vibration::{SubsetConfig, TailError, TailPaths};
use sde_integrators::{GaussianComponent, GaussianMixture, Shark, normal_probability};

use crate::systems::Oscillator;

const SYSTEM: Oscillator = Oscillator { frequency: 2.0, damping: 0.05, intensity: 0.1, cubic: 0.0 };
const COVARIANCE: [[f64; 2]; 2] = [[0.04, 0.03], [0.03, 0.09]];
const TIME: f64 = 2.0;

/// Both tails of a weighted sum of the states beyond a threshold.
fn exact(mean: [f64; 2], weights: [f64; 2], threshold: f64) -> f64 {
    let (phi, covariance) = (SYSTEM.transition(TIME), SYSTEM.covariance(COVARIANCE, TIME));
    let (mut centre, mut variance) = (0.0, 0.0);
    for i in 0..2 {
        for j in 0..2 {
            centre += weights[i] * phi[i][j] * mean[j];
            variance += weights[i] * covariance[i][j] * weights[j];
        }
    }
    let deviation = variance.sqrt();
    normal_probability((centre - threshold) / deviation)
        + normal_probability((-centre - threshold) / deviation)
}

#[test]
fn start_noise_and_both_sides_reach_the_tail() {
    let deviation = SYSTEM.covariance(COVARIANCE, TIME)[0][0].sqrt();
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 8 };
    for (mean, weights) in [([0.0, 0.0], [1.0, 0.0]), ([-0.1, 0.3], [1.0, 0.4])] {
        let law = GaussianMixture::gaussian(mean, COVARIANCE).unwrap();
        let paths = TailPaths::new::<_, _, 1>(&SYSTEM, &Shark, &law, (TIME, 50)).unwrap();
        let paths = paths.with_demand(weights);
        let threshold = 4.0 * deviation;
        let expected = exact(mean, weights, threshold);
        let estimate = paths.subset(threshold, &config, 1).unwrap();
        let error = estimate.standard_error().unwrap();
        assert!(error < 0.2 * expected, "{error:e} of {expected:e}");
        // 50 steps: the variance errs by (omega dt)^2/12, 5e-4 here, times 16/2 in the tail.
        let off = (estimate.value - expected).abs();
        assert!(off < 4.0 * error + 4e-3 * expected, "{off:e}, s.e. {error:e}");
        // Eight runs of at least one level.
        assert!(paths.n_followed() >= 8_000, "{}", paths.n_followed());
    }
}

#[test]
fn a_mixture_at_the_start_is_refused() {
    let half = GaussianComponent { weight: 0.5, mean: [0.0; 2], covariance: COVARIANCE };
    let mixture = GaussianMixture::mixture(&[half; 2]).unwrap();
    let refused = TailPaths::new::<_, _, 1>(&SYSTEM, &Shark, &mixture, (TIME, 50)).unwrap_err();
    assert!(matches!(refused, TailError::Mixture { value: 2 }));
}
