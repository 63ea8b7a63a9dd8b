//! Points of the unit cube, moments over it, Sobol' indices.

use sde_integrators::normal_quantile;
use uq_estimators::{Error, Sampling, SobolPoints, UnitCube};

fn cube(sampling: Sampling, seed: u64, n_points: u64) -> UnitCube {
    UnitCube { dimension: 3, sampling, seed, n_points, n_replicas: 16 }
}

#[test]
fn points_are_those_of_joe_and_kuo() {
    // scipy.stats.qmc.Sobol(50, scramble=False, bits=52) in Gray code order: its point 37 is ours of that code.
    let gray = |index: u64| index ^ index >> 1;
    let points = SobolPoints::new(50, 1, 0).unwrap();
    let mut x = [0.0; 50];
    points.unscrambled(gray(37), &mut x);
    let expected = [0.921875, 0.640625, 0.578125, 0.296875, 0.078125, 0.078125, 0.078125, 0.953125];
    assert_eq!([0, 1, 2, 5, 11, 39, 40, 49].map(|d| x[d]), expected);
    points.unscrambled(gray(63), &mut x);
    assert_eq!(x[49], 0.671875);
}

/// Each elementary interval of `2^m` points in one dimension, and of the net in the first two, holds one point.
#[test]
fn scrambled_points_remain_a_net() {
    let (m, dimension) = (8, 64);
    let n = 1_usize << m;
    for replica in 0..3 {
        let points = SobolPoints::new(dimension, 7, replica).unwrap();
        let mut all = vec![vec![0.0; dimension]; n];
        for (index, x) in (0..).zip(&mut all) {
            points.point(index, x);
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..2^m")]
        let cell = |x: f64, bits: i32| (x * f64::from(bits).exp2()) as usize;
        for d in 0..dimension {
            let mut seen = vec![0; n];
            for x in &all {
                seen[cell(x[d], m)] += 1;
            }
            assert!(seen.iter().all(|count| *count == 1), "dimension {d}");
        }
        for first in 0..=m {
            let mut seen = vec![0; n];
            let rows = 1 << (m - first);
            for x in &all {
                seen[cell(x[0], first) * rows + cell(x[1], m - first)] += 1;
            }
            assert!(seen.iter().all(|count| *count == 1), "{first} digits of the first");
        }
    }
}

#[test]
fn single_scrambled_points_are_uniform_and_independent_between_replicas() {
    // Point 5 over 4000 scrambles: mean 1/2, variance 1/12, and no correlation with point 6 or another dimension.
    let (mut sums, n) = (uq_estimators::Comoments::new(4), 4000);
    for replica in 0..n {
        let points = SobolPoints::new(40, 3, replica).unwrap();
        let (mut a, mut b) = ([0.0; 40], [0.0; 40]);
        points.point(5, &mut a);
        points.point(300, &mut b);
        sums.push(&[a[0], a[39], b[0], b[39]]);
    }
    let n = n as f64;
    for i in 0..4 {
        assert!((sums.mean(i) - 0.5).abs() < 4.0 * (1.0 / 12.0 / n).sqrt(), "{sums:?}");
        assert!((12.0 * sums.variance(i) - 1.0).abs() < 4.0 * (0.8 / n).sqrt(), "{sums:?}");
    }
    for (i, j) in [(0, 1), (0, 3), (1, 2), (2, 3)] {
        assert!((12.0 * sums.covariance(i, j)).abs() < 4.0 / n.sqrt(), "{i} {j} {sums:?}");
    }
}

/// A smooth product with mean 1 and variance `prod (1 + 1/(3 c^2)) - 1`.
fn product(x: &[f64], y: &mut [f64]) -> Result<(), uq_estimators::Failure> {
    y[0] = x.iter().zip([1.0, 2.0, 3.0]).map(|(x, c)| 1.0 + (2.0 * x - 1.0) / c).product();
    Ok(())
}

#[test]
fn quasi_random_moments_are_sharper_and_their_errors_hold() {
    let exact = [1.0, [1.0, 4.0, 9.0].iter().map(|c| 1.0 + 1.0 / (3.0 * c)).product::<f64>() - 1.0];
    let mut error_of = Vec::new();
    for sampling in [Sampling::PseudoRandom, Sampling::ScrambledSobol] {
        let found = cube(sampling, 5, 1 << 10).moments(1, product).unwrap()[0];
        for (estimate, exact) in [found.mean, found.variance].iter().zip(exact) {
            let standard_error = estimate.standard_error().unwrap();
            // 16 replicas: 4.07 standard errors have the probability of 3.3 of a normal distribution, one in a thousand.
            assert!((estimate.value - exact).abs() < 4.07 * standard_error, "{found:?}");
            error_of.push(standard_error);
        }
    }
    assert!(error_of[2] < error_of[0] / 30.0 && error_of[3] < error_of[1] / 30.0, "{error_of:?}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let twice = [1, 2].map(|_| {
        pool.install(|| cube(Sampling::ScrambledSobol, 5, 1 << 10).moments(1, product).unwrap())
    });
    assert_eq!(twice[0], twice[1]);
    assert_eq!(twice[0], cube(Sampling::ScrambledSobol, 5, 1 << 10).moments(1, product).unwrap());
}

#[test]
fn indices_of_a_product_are_its_closed_form() {
    // Variance parts of the factors: t_i = 1/(3 c_i^2); S_i = t_i / V, T_i = t_i prod_(j != i) (1 + t_j) / V.
    let t = [1.0, 4.0, 9.0].map(|c| 1.0 / (3.0 * c));
    let whole: f64 = t.iter().map(|t| 1.0 + t).product();
    let variance = whole - 1.0;
    for sampling in [Sampling::PseudoRandom, Sampling::ScrambledSobol] {
        let found = &cube(sampling, 9, 1 << 9).sobol_indices(1, product).unwrap()[0];
        let within = |estimate: uq_estimators::Estimate, exact: f64| {
            let standard_error = estimate.standard_error().unwrap();
            assert!((estimate.value - exact).abs() < 4.07 * standard_error, "{exact} {found:?}");
        };
        for i in 0..3 {
            within(found.first[i], t[i] / variance);
            within(found.total[i], t[i] * whole / (1.0 + t[i]) / variance);
        }
        within(found.first_sum, t.iter().sum::<f64>() / variance);
        within(found.total_sum, t.iter().map(|t| t * whole / (1.0 + t)).sum::<f64>() / variance);
        within(found.mean, 1.0);
        within(found.variance, variance);
    }
}

/// `exp(sum s_i z_i)`: many small indices, `expm1(s_i^2) / expm1(S)`.
#[test]
fn small_first_order_indices_are_sharper_than_large_ones() {
    let deviations = [0.2, 0.15, 0.25, 0.1, 0.2, 0.3, 0.2, 0.15, 0.2, 0.1];
    let whole: f64 = deviations.iter().map(|s| s * s).sum();
    let product = |x: &[f64], y: &mut [f64]| {
        let sum: f64 = x.iter().zip(deviations).map(|(x, s)| s * normal_quantile(*x)).sum();
        y[0] = sum.exp();
        Ok(())
    };
    let (mut held, mut n) = (0.0, 0.0);
    for seed in 0..6 {
        let sampling = Sampling::ScrambledSobol;
        let cube = UnitCube { dimension: 10, sampling, seed, n_points: 256, n_replicas: 16 };
        let found = &cube.sobol_indices(1, product).unwrap()[0];
        let errors: Vec<f64> =
            found.first.iter().map(|first| first.standard_error().unwrap()).collect();
        // Of the smallest index; by products about a common mean, whose variance is that of a square, 0.007 to 0.013.
        assert!(errors[9] < 0.005 && errors[3] < 0.005, "{errors:?}");
        for ((first, error), s) in found.first.iter().zip(errors).zip(deviations) {
            let exact = (s * s).exp_m1() / whole.exp_m1();
            held += f64::from(u8::from((first.value - exact).abs() < 2.13 * error));
            n += 1.0;
        }
    }
    // 95 % by 15 degrees of freedom, less four deviations of 60 indices, which are not independent.
    assert!(held / n > 0.82, "{held} of {n}");
}

#[test]
fn bad_input_is_refused() {
    let good = cube(Sampling::ScrambledSobol, 1, 64);
    let of = |cube: UnitCube| cube.moments(1, product).unwrap_err();
    assert!(matches!(
        of(UnitCube { n_points: 65, ..good }),
        Error::NotPowerOfTwo { value: 65, .. }
    ));
    assert!(matches!(
        of(UnitCube { n_replicas: 7, ..good }),
        Error::TooFew { value: 7, limit: 8, .. }
    ));
    assert!(matches!(of(UnitCube { dimension: 65, ..good }), Error::TooMany { .. }));
    assert!(matches!(of(UnitCube { dimension: 0, ..good }), Error::TooFew { .. }));
    let found = UnitCube { dimension: 33, ..good }.sobol_indices(1, product);
    assert!(matches!(found, Err(Error::TooMany { .. })), "{found:?}");
    assert!(matches!(good.moments(0, product), Err(Error::TooFew { quantity: "responses", .. })));
    let constant = good.sobol_indices(1, |_, y| {
        y[0] = 0.1;
        Ok(())
    });
    assert!(matches!(constant, Err(Error::NoVariance { response: 0, .. })), "{constant:?}");
    let nan = good.moments(1, |_, y| {
        y[0] = f64::NAN;
        Ok(())
    });
    assert!(matches!(nan, Err(Error::NonFiniteSample { realisation: 0, .. })), "{nan:?}");
}
