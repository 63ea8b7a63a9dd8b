//! Control variates.

use sde_integrators::{Noise, Purpose};
use uq_estimators::{ControlledSamples, Error, Surrogate};

/// Standard normals of a sample.
fn normals<const N: usize>(seed: u64, realisation: u64) -> [f64; N] {
    let mut t = [0.0; N];
    Noise::new(seed).stream(Purpose::Field, realisation).fill_normal(&mut t);
    t
}

/// Repeats 250 samples: estimates without bias, errors that are those of the scatter. Returns the mean standard errors.
fn repeat(
    n_runs: u64,
    exact: [f64; 2],
    surrogates: &[Surrogate],
    sample: impl Fn(&[f64; 2], &mut Vec<f64>),
) -> [f64; 2] {
    let (mut sums, mut squares, mut claimed, mut gained) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
    for seed in 0..n_runs {
        let mut samples = Vec::new();
        (0..250).for_each(|realisation| sample(&normals(seed, realisation), &mut samples));
        let found = ControlledSamples { samples: &samples, surrogates, seed }.estimate().unwrap();
        for (k, estimate) in [found.mean, found.variance].iter().enumerate() {
            let error = estimate.value - exact[k];
            sums[k] += error;
            squares[k] += error * error;
            let standard_error = estimate.standard_error().unwrap();
            claimed[k] += standard_error.powi(2);
            gained[k] += standard_error;
        }
    }
    let n = n_runs as f64;
    for k in 0..2 {
        // Four standard errors of the mean error; a ratio of variances of 300 runs has an error of 0.08, of 100 runs 0.14,
        // and with the tails of squares up to twice that.
        assert!((sums[k] / n).abs() < 4.0 * (squares[k]).sqrt() / n, "{sums:?} {squares:?}");
        assert!((claimed[k] / squares[k] - 1.0).abs() < 6.0 / n.sqrt(), "{claimed:?} {squares:?}");
    }
    gained.map(|sum| sum / n)
}

#[test]
fn split_control_is_unbiased_and_its_errors_are_right() {
    // y = exp(x), x ~ N(0, 0.3^2), by a surrogate of twice its size: the coefficient has to be found.
    let exact = [0.045_f64.exp(), 0.09_f64.exp() * (0.09_f64.exp() - 1.0)];
    let variance = Some(4.0 * 0.09 + 2.0 * 0.09 * 0.09);
    let gained = repeat(300, exact, &[Surrogate { mean: 0.09, variance }], |t, samples| {
        let x = 0.3 * t[0];
        samples.extend([x.exp(), 2.0 * x + x * x]);
    });
    // Raw, the standard error of the mean is 0.02.
    assert!(gained[0] < 0.02 / 10.0, "{gained:?}");
}

#[test]
fn two_surrogates_do_what_neither_does() {
    // y = exp(a + b) with a surrogate of each; the third repeats the first, the fourth is constant.
    let v: f64 = 2.0 * 0.04;
    let exact = [(0.5 * v).exp(), v.exp() * (v.exp() - 1.0)];
    let one = Surrogate { mean: 0.0, variance: Some(0.04) };
    let constant = Surrogate { mean: 1.0, variance: None };
    let both = repeat(100, exact, &[one, one, one, constant], |t, samples| {
        let (a, b) = (0.2 * t[0], 0.2 * t[1]);
        samples.extend([(a + b).exp(), a, b, a, 1.0]);
    });
    let single = repeat(100, exact, &[one], |t, samples| {
        let (a, b) = (0.2 * t[0], 0.2 * t[1]);
        samples.extend([(a + b).exp(), a]);
    });
    // Half of the variance is left by one, about v / 2 = 4 % of it by both.
    assert!(both[0] < 0.4 * single[0], "{both:?} {single:?}");
}

#[test]
fn variances_of_few_normal_samples_hold() {
    let held = |seed: &u64| {
        let samples: [f64; 8] = normals(*seed, 0);
        let found =
            ControlledSamples { samples: &samples, surrogates: &[], seed: 1 }.raw().unwrap();
        let error = found.variance.standard_error().unwrap();
        (found.variance.value - 1.0).abs() <= 2.0 * error
    };
    let share = (0..2000).filter(held).count() as f64 / 2000.0;
    // P(7 s^2 > 7/2.9) = 0.934 by the chi-square distribution of seven degrees, less four standard errors.
    assert!(share > 0.934 - 0.022, "{share}");
}

#[test]
fn equal_samples_have_unknown_errors() {
    let samples = [0.0, -0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let found = ControlledSamples { samples: &samples, surrogates: &[], seed: 1 };
    for moments in [found.raw().unwrap(), found.estimate().unwrap()] {
        assert_eq!(moments.mean.standard_error(), None);
        assert_eq!(moments.variance.standard_error(), None);
    }
}

#[test]
fn bad_samples_are_refused() {
    let surrogates = &[Surrogate { mean: 0.0, variance: Some(1.0) }];
    let of = |samples: &[f64]| ControlledSamples { samples, surrogates, seed: 1 }.estimate();
    assert!(matches!(of(&[1.0; 14]), Err(Error::TooFew { value: 7, limit: 8, .. })));
    assert!(matches!(of(&[1.0; 17]), Err(Error::Length { value: 17, expected: 16, .. })));
    let mut samples = [1.0; 20];
    samples[5] = f64::INFINITY;
    let found = of(&samples);
    assert!(matches!(found, Err(Error::NonFiniteSample { realisation: 2, response: 1, .. })));
    let unknown = &[Surrogate { mean: f64::NAN, variance: None }];
    let found = ControlledSamples { samples: &[1.0; 20], surrogates: unknown, seed: 1 }.estimate();
    assert!(matches!(found, Err(Error::NotFinite { index: 0, .. })));
}
