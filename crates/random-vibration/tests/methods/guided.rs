//! Guided paths.

use random_vibration::{
    ExceedanceQuestion, GuidedConfig, GuidedPaths, Linearisation, LinearisationError, Quadrature,
    TailError, Tails,
};
use sde_integrators::{
    Between, EnsembleConfig, GaussianComponent, GaussianMixture, Response, Shark, Side, maxima,
    normal_probability,
};

use crate::systems::Oscillator;

const SYSTEM: Oscillator = Oscillator { frequency: 2.0, damping: 0.05, intensity: 0.1, cubic: 0.0 };
const COVARIANCE: [[f64; 2]; 2] = [[0.04, 0.03], [0.03, 0.09]];
const TIME: f64 = 2.0;
const RULE: Linearisation<2> =
    Linearisation { order: [(0, Quadrature::Hermite), (1, Quadrature::Hermite)], step: 0.2 };
const CONFIG: GuidedConfig =
    GuidedConfig { n_paths: 2_000, n_pilots: 400, unguided: 0.05, seed: 1 };

fn paths(system: &Oscillator, mean: [f64; 2]) -> GuidedPaths<'_> {
    let law = GaussianMixture::gaussian(mean, COVARIANCE).unwrap();
    GuidedPaths::new(system, &Shark, &law, (TIME, 50), &RULE).unwrap()
}

/// Mean and deviation of a weighted sum of the states.
fn exact(mean: [f64; 2], weights: [f64; 2]) -> (f64, f64) {
    let (phi, covariance) = (SYSTEM.transition(TIME), SYSTEM.covariance(COVARIANCE, TIME));
    let (mut centre, mut variance) = (0.0, 0.0);
    for i in 0..2 {
        for j in 0..2 {
            centre += weights[i] * phi[i][j] * mean[j];
            variance += weights[i] * covariance[i][j] * weights[j];
        }
    }
    (centre, variance.sqrt())
}

#[test]
fn a_linear_demand_is_found_at_any_probability_by_as_many_paths() {
    for (mean, weights, tails) in [
        ([0.0, 0.0], [1.0, 0.0], Tails::Doubled),
        ([0.0, 0.0], [1.0, 0.0], Tails::Both),
        ([-0.1, 0.3], [1.0, 0.4], Tails::Both),
        ([-0.1, 0.3], [1.0, 0.4], Tails::Upper),
    ] {
        let (centre, deviation) = exact(mean, weights);
        let paths = paths(&SYSTEM, mean).with_demand(&weights).unwrap();
        for z in [1.0, 3.0, 6.0, 9.0] {
            let threshold = z * deviation;
            let upper = normal_probability((centre - threshold) / deviation);
            let lower = normal_probability((-centre - threshold) / deviation);
            let expected = if tails == Tails::Upper { upper } else { upper + lower };
            let found = paths.exceedance(threshold, tails, &CONFIG).unwrap();
            let error = found.estimate.standard_error().unwrap();
            // Most of the scatter is that of the start: one large normal, which is shifted but keeps its variance.
            assert!(error < 1.6 * expected / 2_000_f64.sqrt(), "{z}: {found:?}");
            // 50 steps: the variance errs by (omega dt)^2/12, 5e-4 here, times z^2/2 in the tail.
            let off = (found.estimate.value - expected).abs();
            assert!(off < 4.0 * error + 3e-4 * z * z * expected, "{z}: {expected:e} {found:?}");
            assert!(found.n_paths == 2_000 && found.n_hits > 300, "{found:?}");
        }
    }
}

#[test]
fn the_estimate_of_a_nonlinear_system_does_not_depend_on_the_share_or_the_pilots() {
    let system = Oscillator { cubic: 3.0, ..SYSTEM };
    let paths = paths(&system, [0.0; 2]);
    let of = |config: GuidedConfig| {
        let found = paths.exceedance(1.0, Tails::Both, &config).unwrap();
        (found.estimate.value, found.estimate.standard_error().unwrap(), found.strength)
    };
    let many = GuidedConfig { n_paths: 40_000, ..CONFIG };
    let (value, error, _) = of(many);
    assert!(error < 0.03 * value, "{value} {error}");
    for config in [
        GuidedConfig { unguided: 0.0, seed: 2, ..many },
        GuidedConfig { unguided: 0.5, seed: 3, ..many },
        GuidedConfig { n_pilots: 0, seed: 4, ..many },
    ] {
        let (other, more, strength) = of(config);
        assert!((value - other).abs() < 4.0 * error.hypot(more), "{value} {other} {error} {more}");
        // Without pilots the strength is the middle one.
        assert!(config.n_pilots > 0 || (strength - 2.0).abs() < 1e-15);
    }
}

/// Linear: exact at every time and threshold.
#[test]
fn a_surface_over_times_and_thresholds_is_that_of_each_alone() {
    let paths = paths(&SYSTEM, [0.0; 2]);
    let thresholds = [3.0, 4.0, 5.0].map(|z| z * exact([0.0; 2], [1.0, 0.0]).1);
    for tails in [Tails::Doubled, Tails::Both] {
        let question = ExceedanceQuestion {
            thresholds: &thresholds,
            n_steps: &[25, 50],
            tails,
            smallest: 0.0,
        };
        let found = paths.exceedances(&question, &CONFIG).unwrap();
        assert_eq!((found.len(), found[0].len()), (2, 3));
        for (k, row) in found.iter().enumerate() {
            let t = TIME * [0.5, 1.0][k];
            let deviation = SYSTEM.covariance(COVARIANCE, t)[0][0].sqrt();
            for (threshold, found) in thresholds.iter().zip(row) {
                let (found, z) = (found.as_ref().unwrap(), threshold / deviation);
                let expected = 2.0 * normal_probability(-z);
                let error = found.estimate.standard_error().unwrap();
                // A third of the paths is guided to each threshold.
                assert!(error < 1.6 * 3_f64.sqrt() * expected / 2_000_f64.sqrt(), "{found:?}");
                let off = (found.estimate.value - expected).abs();
                assert!(off < 4.0 * error + 3e-4 * z * z * expected, "{z}: {expected:e} {found:?}");
            }
        }
    }
}

#[test]
fn a_threshold_far_below_the_smallest_probability_has_no_guide_and_the_others_gain() {
    let paths = paths(&SYSTEM, [0.0; 2]);
    let deviation = exact([0.0; 2], [1.0, 0.0]).1;
    let (thresholds, tails) = (&[3.0 * deviation, 9.0 * deviation], Tails::Doubled);
    let of = |smallest: f64| {
        let question = ExceedanceQuestion { thresholds, n_steps: &[50], tails, smallest };
        let mut row = paths.exceedances(&question, &CONFIG).unwrap().remove(0);
        let (rare, likely) = (row.remove(1), row.remove(0).unwrap());
        (likely.estimate.standard_error().unwrap() / likely.estimate.value, rare.is_ok())
    };
    let ((among_all, is_rare_found), (alone, is_rare_left)) = (of(0.0), of(1e-6));
    assert!(is_rare_found && !is_rare_left && alone < 0.8 * among_all, "{alone} {among_all}");
}

#[test]
fn invalid_exceedances_are_refused() {
    let paths = paths(&SYSTEM, [0.0; 2]);
    let good = ExceedanceQuestion {
        thresholds: &[1.0],
        n_steps: &[25, 50],
        tails: Tails::Upper,
        smallest: 0.0,
    };
    let many = [1.0; 257];
    for (question, words) in [
        (ExceedanceQuestion { thresholds: &[], ..good }, "thresholds"),
        (ExceedanceQuestion { thresholds: &many, ..good }, "256"),
        (ExceedanceQuestion { thresholds: &[1.0, f64::NAN], ..good }, "threshold"),
        (ExceedanceQuestion { n_steps: &[], ..good }, "times"),
        (ExceedanceQuestion { n_steps: &[50, 25], ..good }, "number of steps to a time"),
        (ExceedanceQuestion { n_steps: &[51], ..good }, "number of steps to a time"),
        (ExceedanceQuestion { smallest: 1.0, ..good }, "smallest probability"),
        (ExceedanceQuestion { smallest: f64::NAN, ..good }, "smallest probability"),
    ] {
        let refused = paths.exceedances(&question, &CONFIG).unwrap_err().to_string();
        assert!(refused.contains(words), "{refused}");
    }
}

#[test]
fn weights_that_cannot_be_trusted_are_refused() {
    // A spring so hard that the linearised system misleads the guide, and few paths.
    let system = Oscillator { cubic: 20.0, ..SYSTEM };
    let config = GuidedConfig { n_paths: 200, ..CONFIG };
    let law = GaussianMixture::gaussian([0.0; 2], COVARIANCE).unwrap();
    let rule = Linearisation { step: 0.01, ..RULE };
    let paths = GuidedPaths::new(&system, &Shark, &law, (TIME, 50), &rule).unwrap();
    let refused = paths.exceedance(1.0, Tails::Both, &config).unwrap_err();
    let text = refused.to_string();
    assert!(matches!(refused, TailError::Untrusted { n_paths: 200, .. }), "{text}");
    assert!(text.contains("of 200 guided paths reached 1"), "{text}");
}

#[test]
fn invalid_input_is_refused() {
    let law = GaussianMixture::gaussian([0.0; 2], COVARIANCE).unwrap();
    let half = GaussianComponent { weight: 0.5, mean: [0.0; 2], covariance: COVARIANCE };
    let mixture = GaussianMixture::mixture(&[half; 2]).unwrap();
    let of = |law, span, rule: &Linearisation<2>| {
        GuidedPaths::new(&SYSTEM, &Shark, law, span, rule).map(drop).unwrap_err()
    };
    assert!(matches!(of(&mixture, (TIME, 50), &RULE), TailError::Mixture { value: 2 }));
    for span in [(TIME, 0), (TIME, 1 << 30), (0.0, 5), (f64::NAN, 5), (-1.0, 5)] {
        assert!(matches!(of(&law, span, &RULE), TailError::Sampling(_)), "{span:?}");
    }
    let rule = Linearisation { step: 0.0, ..RULE };
    let refused = of(&law, (TIME, 50), &rule);
    assert!(matches!(refused, TailError::Linearisation(LinearisationError::Step { .. })));
    let paths = paths(&SYSTEM, [0.0; 2]);
    for (threshold, config) in [
        (f64::INFINITY, CONFIG),
        (f64::NAN, CONFIG),
        (1.0, GuidedConfig { unguided: 1.0, ..CONFIG }),
        (1.0, GuidedConfig { unguided: f64::NAN, ..CONFIG }),
        (1.0, GuidedConfig { n_paths: 1, ..CONFIG }),
        (1.0, GuidedConfig { n_paths: u64::MAX, ..CONFIG }),
    ] {
        let refused = paths.exceedance(threshold, Tails::Both, &config).unwrap_err();
        assert!(matches!(refused, TailError::Sampling(_)), "{refused}");
    }
}

/// Free and guided paths with the same rule between steps, the first by `maxima`.
#[test]
fn first_passage_is_that_of_free_paths_where_they_reach_it_and_is_found_where_they_do_not() {
    let system = Oscillator { cubic: 1.0, ..SYSTEM };
    let law = GaussianMixture::gaussian([0.0; 2], COVARIANCE).unwrap();
    let guided = GuidedPaths::new(&system, &Shark, &law, (4.0, 100), &RULE).unwrap();
    // Of 2,000 paths one may have more than a twentieth of the weight.
    let config = GuidedConfig { n_paths: 8_000, ..CONFIG };
    for side in [Side::Above, Side::Magnitude] {
        let between = Between::CubicHermite { velocity: 1 };
        let response = Response { component: 0, side, between };
        let free = EnsembleConfig { seed: 9, n_paths: 200_000, dt: 0.04, times: vec![4.0] };
        let free = maxima(&system, &Shark, &law, &free, &response).unwrap();
        for threshold in [0.7, 0.9] {
            let expected = free[0].exceedance(threshold).unwrap();
            let found = guided.first_passage(&response, threshold, &config).unwrap();
            let (error, of_free) =
                (found.estimate.standard_error().unwrap(), expected.standard_error().unwrap());
            assert!(error < 0.05 * found.estimate.value, "{threshold}: {found:?}");
            let off = (found.estimate.value - expected.value).abs();
            assert!(off < 4.0 * error.hypot(of_free), "{threshold}: {expected} {found:?}");
        }
        let rare = guided.first_passage(&response, 1.6, &config).unwrap();
        assert!(rare.estimate.value < 1e-7 && rare.n_hits > 1_500, "{rare:?}");
        assert!(rare.estimate.standard_error().unwrap() < 0.1 * rare.estimate.value, "{rare:?}");
    }
    let response = Response { component: 2, side: Side::Above, between: Between::Endpoints };
    let refused = guided.first_passage(&response, 1.0, &CONFIG).unwrap_err();
    assert!(matches!(refused, TailError::Sampling(_)), "{refused}");
}
