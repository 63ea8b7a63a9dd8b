//! Distributions at one point, and the correlation that they keep.

use random_fields::{Error, Marginal};

const LAWS: [Marginal; 6] = [
    Marginal::Uniform { low: -1.0, high: 3.0 },
    Marginal::Lognormal { mean: 2.0, coefficient_of_variation: 0.3 },
    Marginal::Weibull { mean: 0.01, shape: 5.0 },
    Marginal::Weibull { mean: 3.0, shape: 1.0 },
    Marginal::Normal { mean: 1.0, standard_deviation: 0.1 },
    Marginal::Weibull { mean: 1.0, shape: 0.4 },
];

/// `E[g(z)]` by the trapezoidal rule, whose error for these is below 1e-10.
fn expectation(g: impl Fn(f64) -> f64) -> f64 {
    let weight = |z: f64| f64::exp(-0.5 * z * z) / f64::sqrt(2.0 * std::f64::consts::PI);
    (-600..=600).map(|k| f64::from(k) / 64.0).map(|z| weight(z) * g(z) / 64.0).sum()
}

#[test]
fn mean_and_deviation_are_those_of_the_values() {
    for law in LAWS {
        law.check().unwrap();
        let mean = expectation(|z| law.at(z));
        let variance = expectation(|z| (law.at(z) - mean).powi(2));
        assert!((mean / law.mean() - 1.0).abs() < 1e-9, "{law:?}: {mean}");
        let deviation = variance.sqrt() / law.standard_deviation();
        assert!((deviation - 1.0).abs() < 1e-9, "{law:?}: {deviation}");
    }
}

#[test]
fn weibull_of_shape_one_is_exponential_in_both_tails() {
    let law = Marginal::Weibull { mean: 1.0, shape: 1.0 };
    // Phi(-6) = 9.865876450376946e-10 (Abramowitz and Stegun, table 26.1 gives 9.8659e-10), and -ln(1 - p) = p + p^2/2;
    // above, -ln Phi(-6) = 20.736768903.
    assert!((law.at(-6.0) / 9.865876455243e-10 - 1.0).abs() < 1e-11, "{:e}", law.at(-6.0));
    assert!((law.at(6.0) - 9.865876450376946e-10_f64.ln().abs()).abs() < 1e-12);
    assert!((law.at(0.0) - std::f64::consts::LN_2).abs() < 1e-15);
}

#[test]
fn lognormal_median_is_the_mean_over_the_root_of_one_plus_the_square_of_the_variation() {
    let law = Marginal::Lognormal { mean: 2.0, coefficient_of_variation: 0.75 };
    assert!((law.at(0.0) - 1.6).abs() < 1e-14);
}

#[test]
fn correlation_is_the_covariance_of_two_values_over_their_variance() {
    for law in LAWS {
        for rho in [-0.8, -0.3, 0.2, 0.6, 0.95_f64] {
            let across = (1.0 - rho * rho).sqrt();
            let (mean, variance) = (law.mean(), law.standard_deviation().powi(2));
            let product = |a: f64| expectation(|b| law.at(rho * a + across * b)) * law.at(a);
            let expected = (expectation(product) - mean * mean) / variance;
            let found = law.translated_correlation(rho).unwrap();
            // Roundoff of the rule: the variance is a hundredth of the square of the mean, or 28 times it.
            assert!((found - expected).abs() < 1e-11, "{law:?}, {rho}: {found} {expected}");
        }
        assert!((law.translated_correlation(1.0).unwrap() - 1.0).abs() < 1e-14, "{law:?}");
    }
}

#[test]
fn correlation_keeps_near_that_of_the_normal_for_a_scatter_of_thirty_percent() {
    let laws = [LAWS[1], Marginal::Weibull { mean: 1.0, shape: 3.7 }];
    for law in laws {
        assert!((law.standard_deviation() / law.mean() - 0.3).abs() < 0.005);
        for k in -6..=20 {
            let rho = 0.05 * f64::from(k);
            assert!(
                (law.translated_correlation(rho).unwrap() - rho).abs() < 0.02,
                "{law:?}, {rho}"
            );
        }
    }
}

#[test]
fn normal_law_that_reaches_below_zero_is_refused_with_its_probability() {
    // Phi(-5) = 2.8665e-7 (Abramowitz and Stegun, table 26.2).
    let found = Marginal::Normal { mean: 1.0, standard_deviation: 0.2 }.check_positive();
    let Err(Error::NegativeField { probability, .. }) = found else { unreachable!("{found:?}") };
    assert!((probability / 2.8665e-7 - 1.0).abs() < 1e-4);
    assert!(Marginal::Normal { mean: 7.9, standard_deviation: 1.0 }.check_positive().is_err());
    assert!(Marginal::Normal { mean: 8.0, standard_deviation: 1.0 }.check_positive().is_ok());
}

#[test]
fn parameters_that_cannot_be_are_refused() {
    let lognormal =
        |mean, coefficient_of_variation| Marginal::Lognormal { mean, coefficient_of_variation };
    for law in [lognormal(0.0, 0.1), lognormal(1.0, -0.1), lognormal(1.0, f64::NAN)] {
        assert!(matches!(law.check(), Err(Error::NotPositive { .. })), "{law:?}");
    }
    let law = Marginal::Weibull { mean: 1.0, shape: 0.1 };
    assert!(matches!(law.check(), Err(Error::OutOfRange { .. })));
}

#[test]
fn derivative_is_that_of_the_value() {
    for law in LAWS {
        for z in [-4.0, -1.0, 0.0, 0.3, 2.5] {
            let slope = (law.at(z + 1e-5) - law.at(z - 1e-5)) / 2e-5;
            // Central differences: h^2/6 of the third derivative, and roundoff over h.
            let error = (law.derivative(z) - slope).abs() / law.standard_deviation();
            assert!(error < 1e-9, "{law:?} at {z}: {error:e}");
        }
    }
}

#[test]
fn correlation_of_the_normals_is_the_inverse_and_ends_where_no_translation_reaches() {
    for law in LAWS {
        for rho in [-1.0, -0.4, 0.0, 0.3, 0.99, 1.0] {
            let back = law.normal_correlation(law.translated_correlation(rho).unwrap()).unwrap();
            assert!((back - rho).abs() < 1e-11, "{law:?}, {rho}: {back}");
        }
        assert!(matches!(law.normal_correlation(1.1), Err(Error::OutOfRange { .. })));
    }
    let wide = Marginal::Lognormal { mean: 1.0, coefficient_of_variation: 2.0 };
    // exp(-s^2) = 1/5: (1/5 - 1)/(5 - 1).
    let refused = wide.normal_correlation(-0.25);
    let Err(Error::CorrelationBelowLeast { limit, .. }) = refused else {
        unreachable!("{refused:?}")
    };
    assert!((limit + 0.2).abs() < 1e-15);
    // An exponential distribution: 1 - pi^2/6 for opposed quantiles.
    let refused = Marginal::Weibull { mean: 1.0, shape: 1.0 }.normal_correlation(-0.7);
    let Err(Error::CorrelationBelowLeast { limit, .. }) = refused else {
        unreachable!("{refused:?}")
    };
    assert!((limit - (1.0 - std::f64::consts::PI.powi(2) / 6.0)).abs() < 1e-13, "{limit}");
}

#[test]
fn weibull_of_a_coefficient_of_variation_has_it_and_one_out_of_range_is_refused() {
    for v in [0.0013, 0.05, 0.3, 1.0, 15.0] {
        let law = Marginal::weibull(2.0, v).unwrap();
        // Near the shape 1000 the logarithms of the gamma functions cancel to a millionth.
        assert!((law.standard_deviation() / (2.0 * v) - 1.0).abs() < 1e-9, "{v}: {law:?}");
    }
    for v in [0.001, 16.0, 0.0, -1.0, f64::NAN] {
        assert!(matches!(Marginal::weibull(1.0, v), Err(Error::OutOfRange { .. })), "{v}");
    }
}

#[test]
fn normal_score_is_the_inverse_and_impossible_values_are_refused() {
    for law in LAWS {
        for z in [-3.0, -0.5, 0.0, 1.0, 4.0] {
            let back = law.normal_score(law.at(z)).unwrap();
            // A uniform value at 4 deviations is 3e-5 of its range below the end: 2e-16 over the density 1.3e-4.
            assert!((back - z).abs() < 1e-11, "{law:?}, {z}: {back}");
        }
        assert!(matches!(law.normal_score(-1.5), Err(Error::OutOfRange { .. })));
    }
}
