//! What moments obey whatever the response: exact for the polynomials they are exact for, the same in every coordinates.

use perturbation_moments::{
    AlongDirections, Error, Expansion, Marginal, Moments, MonteCarlo, RandomVector, Verdict,
};
use proptest::prelude::*;

const N: usize = 3;

/// A response of at most third degree in three inputs, by its derivatives at the mean.
fn cubic() -> impl Strategy<Value = Expansion<N>> {
    let number = -2.0..2.0_f64;
    (number.clone(), prop::array::uniform3(number.clone()), prop::collection::vec(number, 16))
        .prop_map(|(value, gradient, rest)| {
            let mut expansion = Expansion::from_derivatives(|by| match *by {
                [i, j] => rest[[0, 1, 2, 1, 3, 4, 2, 4, 5][3 * i + j]],
                [i, j, k] => rest[6 + (i + j + k) % 7 + i],
                _ => 0.0,
            });
            (expansion.value, expansion.gradient) = (value, gradient);
            expansion
        })
}

/// A random vector whose correlation is that of random unit vectors: positive semidefinite by construction.
fn inputs() -> impl Strategy<Value = RandomVector<N>> {
    let directions = prop::array::uniform3(prop::array::uniform3(-1.0..1.0_f64));
    let means = prop::array::uniform3(0.5..3.0_f64);
    let deviations = prop::array::uniform3(0.05..1.0_f64);
    (means, deviations, directions).prop_filter_map("directions too short", |(m, s, d)| {
        let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if d.iter().any(|v| length(v) < 0.1) {
            return None;
        }
        let cosine = |a: &[f64; 3], b: &[f64; 3]| {
            let product: f64 = (0..3).map(|k| a[k] * b[k]).sum();
            product / (length(a) * length(b))
        };
        let mut correlation = [[1.0; 3]; 3];
        for i in 0..3 {
            for j in 0..i {
                (correlation[i][j], correlation[j][i]) =
                    (cosine(&d[i], &d[j]), cosine(&d[i], &d[j]));
            }
        }
        RandomVector::new(m, s, correlation).ok()
    })
}

/// `E[p(t)]` for a polynomial of degree 9 at most in each of three standard normals, by five-point Gauss-Hermite (exact to
/// degree 9; nodes are the roots of `t^5 - 10 t^3 + 15 t`, weights `24/(5 He_4(t)^2)`).
fn expectation(f: impl Fn(&[f64; N]) -> f64) -> f64 {
    let nodes: Vec<(f64, f64)> =
        [0.0, (5.0 - 10.0_f64.sqrt()).sqrt(), (5.0 + 10.0_f64.sqrt()).sqrt()]
            .into_iter()
            .flat_map(|t| if t > 0.0 { vec![t, -t] } else { vec![t] })
            .map(|t: f64| (t, 24.0 / (5.0 * (t.powi(4) - 6.0 * t * t + 3.0).powi(2))))
            .collect();
    let mut sum = 0.0;
    for (a, wa) in &nodes {
        for (b, wb) in &nodes {
            for (c, wc) in &nodes {
                sum += wa * wb * wc * f(&[*a, *b, *c]);
            }
        }
    }
    sum
}

/// The response itself, from its expansion.
fn at(expansion: &Expansion<N>, inputs: &RandomVector<N>, t: &[f64; N]) -> f64 {
    let (x, centre) = (inputs.point(t), inputs.centre());
    let d: [f64; N] = std::array::from_fn(|i| x[i] - centre[i]);
    let mut y = expansion.value;
    for i in 0..N {
        y += expansion.gradient[i] * d[i];
        for j in 0..N {
            y += 0.5 * expansion.hessian.unwrap()[i][j] * d[i] * d[j];
            for k in 0..N {
                y += expansion.third.map_or(0.0, |t| t[i][j][k]) / 6.0 * d[i] * d[j] * d[k];
            }
        }
    }
    y
}

/// A bound on what moments of order `power` can be: what roundoff is relative to.
fn scale(expansion: &Expansion<N>, inputs: &RandomVector<N>, power: i32) -> f64 {
    expectation(|t| at(expansion, inputs, t).abs().max(1.0).powi(power))
}

proptest! {
    #[test]
    fn a_quadratic_of_gaussians_has_its_moments_exactly(expansion in cubic(), inputs in inputs()) {
        let quadratic = Expansion { third: None, ..expansion };
        let moments = Moments::new(&inputs, &quadratic).unwrap();
        let mean = expectation(|t| at(&quadratic, &inputs, t));
        prop_assert!((moments.mean_second_order().unwrap() - mean).abs() < 1e-12 * scale(&quadratic, &inputs, 1));
        // The mean is taken out first, so that a large constant does not drown what is left.
        let central = |power: i32| expectation(|t| (at(&quadratic, &inputs, t) - mean).powi(power));
        let roundoff = |power: i32| 1e-11 * scale(&quadratic, &inputs, power);
        prop_assert!((moments.variance_with_curvature().unwrap() - central(2)).abs() < roundoff(2));
        prop_assert!((moments.third_central_moment().unwrap() - central(3)).abs() < roundoff(3));
        let cumulant = central(4) - 3.0 * central(2).powi(2);
        prop_assert!((moments.fourth_cumulant().unwrap() - cumulant).abs() < 10.0 * roundoff(4));
        prop_assert!((moments.surrogate_variance() - central(2)).abs() < roundoff(2));
    }

    #[test]
    fn a_cubic_has_its_mean_exactly_and_its_variance_to_fourth_order(expansion in cubic(), inputs in inputs()) {
        let moments = Moments::new(&inputs, &expansion).unwrap();
        let mean = expectation(|t| at(&expansion, &inputs, t));
        prop_assert!((moments.mean_second_order().unwrap() - mean).abs() < 1e-12 * scale(&expansion, &inputs, 1));
        // What the fourth-order variance leaves out is the variance of the cubic part alone: that of order sigma^6.
        let cubic = Expansion { value: 0.0, gradient: [0.0; N], hessian: Some([[0.0; N]; N]), ..expansion };
        let left_out = expectation(|t| at(&cubic, &inputs, t).powi(2));
        let variance = expectation(|t| (at(&expansion, &inputs, t) - mean).powi(2));
        let error = moments.variance_fourth_order().unwrap() + left_out - variance;
        prop_assert!(error.abs() < 1e-11 * scale(&expansion, &inputs, 2), "{error:e}");
    }

    #[test]
    fn importance_factors_sum_to_one(expansion in cubic(), inputs in inputs()) {
        let moments = Moments::new(&inputs, &expansion).unwrap();
        prop_assume!(moments.variance_first_order() > 1e-6);
        let sum: f64 = moments.importance_factors().unwrap().iter().sum();
        prop_assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn moments_do_not_hang_on_units(expansion in cubic(), inputs in inputs(), unit in 1e-9..1e9_f64) {
        // The first input in another unit: x1 = unit x1', so each derivative by it grows by the unit.
        let factor = |by: &[usize]| by.iter().map(|&i| if i == 0 { unit } else { 1.0 }).product::<f64>();
        let scaled = Expansion::from_derivatives(|by| factor(by) * match *by {
            [i] => expansion.gradient[i],
            [i, j] => expansion.hessian.unwrap()[i][j],
            [i, j, k] => expansion.third.unwrap()[i][j][k],
            _ => expansion.value,
        });
        let (mut mean, mut deviations) = (*inputs.mean(), *inputs.deviations());
        mean[0] /= unit;
        deviations[0] /= unit;
        let covariance = inputs.covariance();
        let s = inputs.deviations();
        let correlation = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { 1.0 } else { covariance[i][j] / (s[i] * s[j]) })
        });
        let other = RandomVector::new(mean, deviations, correlation).unwrap();
        let (here, there) = (Moments::new(&inputs, &expansion).unwrap(), Moments::new(&other, &scaled).unwrap());
        let (a, b) = (here.variance_fourth_order().unwrap(), there.variance_fourth_order().unwrap());
        prop_assert!((a - b).abs() < 1e-11 * scale(&expansion, &inputs, 2), "{a} {b}");
        let (a, b) = (here.third_central_moment().unwrap(), there.third_central_moment().unwrap());
        prop_assert!((a - b).abs() < 1e-11 * scale(&expansion, &inputs, 3), "{a} {b}");
    }

    #[test]
    fn all_probes_together_give_the_mixed_curvature_exactly(expansion in cubic(), inputs in inputs()) {
        let full = Moments::new(&inputs, &Expansion { third: None, ..expansion }).unwrap();
        let probes = [[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [1.0, -1.0, -1.0]];
        let x = inputs.jets_with_probes(&probes);
        let centre = inputs.centre();
        let mut y = x[0] * 0.0 + expansion.value;
        for i in 0..N {
            y = y + (x[i] - centre[i]) * expansion.gradient[i];
            for j in 0..N {
                y = y + (x[i] - centre[i]) * (x[j] - centre[j]) * (0.5 * expansion.hessian.unwrap()[i][j]);
            }
        }
        let probed = Moments::along(&inputs, &AlongDirections::from_jet(&y, 4)).unwrap();
        let (a, b) = (full.variance_with_curvature().unwrap(), probed.variance_with_curvature().unwrap());
        prop_assert!((a - b).abs() < 1e-12 * scale(&expansion, &inputs, 2), "{a} {b}");
        let (a, b) = (full.mean_second_order().unwrap(), probed.mean_second_order().unwrap());
        prop_assert!((a - b).abs() < 1e-12 * scale(&expansion, &inputs, 1), "{a} {b}");
        prop_assert!(probed.third_central_moment().is_err());
        prop_assume!(full.variance_first_order() > 1e-6);
        let factors = (full.importance_factors().unwrap(), probed.importance_factors());
        if let (a, Ok(b)) = factors {
            let worst = (0..N).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
            // The triangular solve multiplies roundoff by the condition of L.
            prop_assert!(worst < 1e-4, "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_correlation_with_a_negative_eigenvalue_is_refused_by_its_number(r in 0.51..0.99_f64) {
        // Equal correlation -r in three dimensions has the eigenvalue 1 - 2r < 0.
        let correlation = [[1.0, -r, -r], [-r, 1.0, -r], [-r, -r, 1.0]];
        match RandomVector::new([0.0; 3], [1.0; 3], correlation) {
            Err(Error::NotPositiveSemidefinite { index: 0, eigenvalue, .. }) => {
                prop_assert!((eigenvalue - (1.0 - 2.0 * r)).abs() < 1e-14);
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn a_product_of_lognormals_is_lognormal(
        cv in prop::array::uniform2(0.01..0.5_f64),
        mean in prop::array::uniform2(0.1..10.0_f64),
        rho in -0.6..0.9_f64,
    ) {
        // y = x1 x2. E y = mu1 mu2 (1 + rho delta1 delta2) by the definition of the correlation. Near the centre
        // y = y0 exp(v) with v normal of variance s^2: the series of mean and variance are those of the exponential.
        let deviations = [mean[0] * cv[0], mean[1] * cv[1]];
        let inputs = RandomVector::new(mean, deviations, [[1.0, rho], [rho, 1.0]])
            .and_then(|inputs| inputs.with_marginals([Marginal::Lognormal; 2]));
        prop_assume!(inputs.is_ok());
        let inputs = inputs.unwrap();
        let [a, b] = inputs.centre();
        let product = Expansion::from_derivatives(|by| match by {
            [] => a * b,
            [0] => b,
            [1] => a,
            [0, 1] => 1.0,
            _ => 0.0,
        });
        let moments = Moments::new(&inputs, &product).unwrap();
        let y0 = moments.mean_first_order();
        let exact_mean = mean[0] * mean[1] * (1.0 + rho * cv[0] * cv[1]);
        let v = 2.0 * (exact_mean / y0).ln();
        prop_assert!((moments.variance_first_order() / (y0 * y0) - v).abs() < 1e-12);
        prop_assert!((moments.mean_second_order().unwrap() / y0 - 1.0 - v / 2.0).abs() < 1e-12);
        // exp(v)(exp(v) - 1) = v + 3/2 v^2 + O(v^3).
        let fourth = moments.variance_fourth_order().unwrap() / (y0 * y0);
        prop_assert!((fourth - v - 1.5 * v * v).abs() < 1e-12);
    }
}

#[test]
fn what_needs_the_full_hessian_is_refused_from_a_diagonal() {
    let inputs = RandomVector::independent([1.0, 2.0], [0.1, 0.1]).unwrap();
    let [x1, x2] = inputs.jets();
    let known = AlongDirections::<2>::from_jet(&(x1 * x2), 0);
    let moments = Moments::along(&inputs, &known).unwrap();
    assert!(moments.mean_second_order().is_ok());
    let refused = moments.variance_with_curvature().unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the variance with curvature needs the full Hessian or a probe, only their diagonal is given"
    );
    assert!(matches!(moments.third_central_moment(), Err(Error::CurvatureIncomplete { .. })));
    assert!(matches!(moments.fourth_cumulant(), Err(Error::CurvatureIncomplete { .. })));
    assert!(matches!(moments.variance_fourth_order(), Err(Error::ThirdDerivativesMissing { .. })));
    assert_eq!(moments.trust().unwrap().verdict(), Verdict::Unknown);
}

#[test]
fn a_flat_response_has_no_first_order_variance() {
    let inputs = RandomVector::independent([0.0, 0.0], [1.0, 1.0]).unwrap();
    let bowl = Expansion {
        value: 0.0,
        gradient: [0.0, 0.0],
        hessian: Some([[2.0, 0.0], [0.0, 2.0]]),
        third: None,
    };
    let moments = Moments::new(&inputs, &bowl).unwrap();
    assert!(matches!(moments.trust(), Err(Error::NoFirstOrderVariance { .. })));
    assert!(matches!(moments.importance_factors(), Err(Error::NoFirstOrderVariance { .. })));
    // x1^2 + x2^2 has variance 4 all the same.
    assert!((moments.variance_with_curvature().unwrap() - 4.0).abs() < 1e-15);
    // Terms that cancel under full correlation leave roundoff, which is no variance either.
    let tied = RandomVector::new([0.0, 0.0], [0.1, 0.3], [[1.0, 1.0], [1.0, 1.0]]).unwrap();
    let cancelling = Expansion { gradient: [3.0, -1.0], hessian: None, ..bowl };
    let moments = Moments::new(&tied, &cancelling).unwrap();
    assert!(matches!(moments.trust(), Err(Error::NoFirstOrderVariance { .. })));
}

#[test]
fn importance_may_be_negative_under_correlation() {
    // y = x1 + 0.1 x2, deviations one, rho = -0.6: factors (1 - 0.06)/v and (0.01 - 0.06)/v, v = 0.89.
    let inputs = RandomVector::new([0.0; 2], [1.0; 2], [[1.0, -0.6], [-0.6, 1.0]]).unwrap();
    let sum = Expansion { value: 0.0, gradient: [1.0, 0.1], hessian: None, third: None };
    let [a, b] = Moments::new(&inputs, &sum).unwrap().importance_factors().unwrap();
    assert!((a - 0.94 / 0.89).abs() < 1e-14 && (b + 0.05 / 0.89).abs() < 1e-14);
}

#[test]
fn inputs_that_cannot_be_are_refused_by_name() {
    let identity = [[1.0, 0.0], [0.0, 1.0]];
    let negative = RandomVector::new([0.0; 2], [1.0, -1.0], identity);
    assert!(matches!(negative, Err(Error::Negative { index: 1, .. })), "{negative:?}");
    let asymmetric = RandomVector::new([0.0; 2], [1.0; 2], [[1.0, 0.3], [0.2, 1.0]]);
    assert!(matches!(asymmetric, Err(Error::NotSymmetric { row: 1, column: 0, .. })));
    let beyond = RandomVector::new([0.0; 2], [1.0; 2], [[1.0, 1.2], [1.2, 1.0]]);
    assert!(matches!(beyond, Err(Error::Correlation { row: 0, column: 1, .. })));
    let below = RandomVector::independent([1.0, -1.0], [0.1; 2])
        .and_then(|x| x.with_marginals([Marginal::Normal, Marginal::Lognormal]));
    assert!(matches!(below, Err(Error::LognormalMean { index: 1, .. })));
    // Lognormals of coefficient of variation 1 have no correlation below (exp(-ln 2) - 1)/1 = -0.5.
    let opposed = RandomVector::new([1.0; 2], [1.0; 2], [[1.0, -0.6], [-0.6, 1.0]])
        .and_then(|x| x.with_marginals([Marginal::Lognormal; 2]));
    assert!(matches!(opposed, Err(Error::Correlation { row: 1, column: 0, .. })), "{opposed:?}");
}

#[test]
fn samples_have_the_mean_deviation_and_correlation_that_were_asked_for() {
    let (mean, deviations) = ([2.0, 3.0, 1.0], [0.8, 0.6, 0.2]);
    let correlation = [[1.0, 0.5, -0.3], [0.5, 1.0, 0.2], [-0.3, 0.2, 1.0]];
    let inputs = RandomVector::new(mean, deviations, correlation)
        .and_then(|x| {
            x.with_marginals([Marginal::Lognormal, Marginal::Lognormal, Marginal::Normal])
        })
        .unwrap();
    let constant = Expansion { value: 0.0, gradient: [0.0; 3], hessian: None, third: None };
    let none = Moments::new(&inputs, &constant).unwrap();
    let judge = MonteCarlo { seed: 20, n_samples: 100_000 };
    for i in 0..3 {
        for j in 0..=i {
            let found = judge
                .judge(&inputs, &none, |x| (x[i] - mean[i]) * (x[j] - mean[j]))
                .unwrap()
                .raw_mean;
            let exact = correlation[i][j] * deviations[i] * deviations[j];
            let standard_error = found.standard_error().unwrap();
            assert!((found.value - exact).abs() < 4.0 * standard_error, "({i}, {j}): {found}");
            assert!(standard_error < 0.02 * deviations[i] * deviations[j]);
        }
    }
}

/// The points of unit normals, of unit deviations about zero, are the columns of a factor of the correlation.
#[test]
fn a_singular_correlation_has_a_factor() {
    let s = [[1.0, 1.0, 0.6], [1.0, 1.0, 0.6], [0.6, 0.6, 1.0]];
    let inputs = RandomVector::new([0.0; 3], [1.0; 3], s).unwrap();
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|t| inputs.point(&t));
    assert_eq!(columns[1][1].to_bits(), 0.0_f64.to_bits());
    for i in 0..3 {
        for j in 0..3 {
            let product: f64 = columns.iter().map(|column| column[i] * column[j]).sum();
            assert!((product - s[i][j]).abs() < 1e-15);
        }
    }
}
