//! Quantiles.

use sde_integrators::{Noise, Purpose};
use uq_estimators::{Error, Sampling, UnitCube, quantile};

#[test]
fn intervals_hold_as_often_as_they_say() {
    for (n, p) in [(60, 0.5), (200, 0.9), (400, 0.98)] {
        let (n_runs, mut hits, mut confidence) = (4_000, 0, 0.0);
        for seed in 0..n_runs {
            let mut stream = Noise::new(seed).stream(Purpose::Field, n);
            let samples: Vec<f64> = (0..n).map(|_| stream.next_uniform().powi(3)).collect();
            let found = quantile(&samples, p, 0.95).unwrap();
            let exact = p.powi(3);
            hits += u32::from(found.interval[0] <= exact && exact <= found.interval[1]);
            confidence = found.confidence;
            assert!(found.interval[0] <= found.value && found.value <= found.interval[1]);
        }
        let part = f64::from(hits) / n_runs as f64;
        // Four standard errors of 4,000 runs: 1.4 %.
        assert!((part - confidence).abs() < 0.014, "{n} {p}: {part} {confidence}");
        assert!((0.95..0.98).contains(&confidence), "{n} {p}: {confidence}");
    }
}

/// `P(K < 40)` and `P(K >= 61)` of 100 tosses are 0.0176, one place further in 0.0284: 40 and 61 are the places at 95 %.
#[test]
fn places_are_those_of_the_binomial_distribution() {
    let samples: Vec<f64> = (1..=100).rev().map(f64::from).collect();
    let found = quantile(&samples, 0.5, 0.95).unwrap();
    assert_eq!((found.value, found.interval), (50.0, [40.0, 61.0]));
    // 1 - 2 P(K <= 39) with P(K <= 39) = 0.017600 (Abramowitz and Stegun, table of the binomial distribution).
    assert!((found.confidence - (1.0 - 2.0 * 0.017_600_1)).abs() < 1e-6, "{found:?}");
    // The median of six: between the extremes with 1 - 2/64.
    let six = quantile(&samples[..6], 0.5, 0.95).unwrap();
    assert_eq!((six.interval, six.confidence), ([95.0, 100.0], 1.0 - 2.0 / 64.0));
}

#[test]
fn replicas_have_a_smaller_error_than_independent_samples() {
    let of = |sampling| {
        let cube = UnitCube { dimension: 2, sampling, seed: 7, n_points: 256, n_replicas: 32 };
        let runs = cube.runs().unwrap();
        let mut x = [0.0; 2];
        let values: Vec<f64> = (0..runs.n_runs())
            .map(|run| {
                runs.input(run, &mut x);
                x[0] + x[1]
            })
            .collect();
        cube.quantile_of_runs(&values, 0.9).unwrap()
    };
    // P(x + y > t) = (2 - t)^2 / 2.
    let exact = 2.0 - 0.2_f64.sqrt();
    let (plain, sobol) = (of(Sampling::PseudoRandom), of(Sampling::ScrambledSobol));
    let [a, b] = [plain, sobol].map(|found| {
        let error = found.standard_error().unwrap();
        assert!((found.value - exact).abs() < 4.0 * error, "{found:?} {exact}");
        error
    });
    assert!(b < 0.3 * a, "{plain:?} {sobol:?}");
}

#[test]
fn bad_input_is_refused() {
    let samples = [1.0, 2.0, 3.0, 4.0, 5.0];
    let few = quantile(&samples, 0.5, 0.95);
    assert!(matches!(few, Err(Error::TooFew { value: 5, limit: 6, .. })), "{few:?}");
    for p in [0.0, 1.0, f64::NAN, -0.1] {
        let found = quantile(&samples, p, 0.5);
        assert!(matches!(found, Err(Error::OutsideOpenInterval { .. })), "{found:?}");
        let found = quantile(&samples, 0.5, p);
        assert!(matches!(found, Err(Error::OutsideOpenInterval { .. })), "{found:?}");
    }
    let nan = quantile(&[0.0, f64::NAN], 0.5, 0.1);
    assert!(matches!(nan, Err(Error::NotFinite { index: 1, .. })), "{nan:?}");
    assert!(matches!(quantile(&[], 0.5, 0.1), Err(Error::TooFew { .. })));
    let cube = UnitCube {
        dimension: 1,
        sampling: Sampling::ScrambledSobol,
        seed: 1,
        n_points: 64,
        n_replicas: 8,
    };
    let values = vec![0.5; 512];
    assert!(matches!(cube.quantile_of_runs(&values, 0.875), Err(Error::TooFew { limit: 80, .. })));
    assert!(matches!(cube.quantile_of_runs(&values[1..], 0.5), Err(Error::Length { .. })));
}
