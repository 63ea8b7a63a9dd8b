//! Jets, dual numbers and closed forms against each other.

use crate::responses::{JohnsonCook, MieGruneisen, MieGruneisenState};
use perturbation_moments::{
    Error, Expansion, ForwardDifferentiation, Gradient, HighestOrder, Jet, Moments, MonteCarlo,
    RandomVector, Response, Scalar, SigmaPoints, Slopes, Verdict,
};
use proptest::prelude::*;

/// Every operation of a scalar at least once, smooth for positive inputs.
struct Everything;

impl Response<3> for Everything {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        let [a, b, c] = *x;
        let powers = a.powf(1.7) * b.powi(3) + c.powi(-2) - a.powi(1) + b.powi(0);
        let roots = (a * b + 2.0).sqrt() / (c + 1.0).ln() - b.recip();
        let waves = (-a * 0.5).exp() * (b - c).sin() + (c * a).cos() / 3.0;
        let mixed = c.exp_scaled(-0.3).squared() - 1.5;
        powers * 0.1 + roots + waves * mixed + S::constant(4.0)
    }
}

fn forward<const N: usize>(response: &impl Response<N>, x: &[f64; N]) -> Expansion<N> {
    ForwardDifferentiation { response, order: HighestOrder::Third }.expansion(x)
}

/// Entries of two expansions side by side, each times the inputs it is by, and the largest of their kind.
fn compare<const N: usize>(
    ours: &Expansion<N>,
    other: &Expansion<N>,
    x: &[f64; N],
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let mut pairs = Vec::new();
    for i in 0..N {
        pairs.push((x[i], ours.gradient[i], other.gradient[i]));
        for j in 0..N {
            let (a, b) = (ours.hessian.unwrap(), other.hessian.unwrap());
            pairs.push((x[i] * x[j], a[i][j], b[i][j]));
            for k in 0..N {
                if let (Some(a), Some(b)) = (ours.third, other.third) {
                    pairs.push((x[i] * x[j] * x[k], a[i][j][k], b[i][j][k]));
                }
            }
        }
    }
    pairs.push((1.0, ours.value, other.value));
    let scale = pairs.iter().fold(0.0_f64, |largest, (w, _, b)| largest.max((w * b).abs()));
    for (weight, a, b) in pairs {
        prop_assert!(
            (weight * (a - b)).abs() <= tolerance * scale,
            "{a} against {b}, scale {scale}"
        );
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_jet_agrees_with_dual_numbers_to_roundoff(x in prop::array::uniform3(0.3..2.5_f64)) {
        let jets = std::array::from_fn(|k| Jet::variable(x[k], k));
        let y = Everything.value(&jets);
        let judge = forward(&Everything, &x);
        let scale = 1.0 + judge.hessian.unwrap().iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
        prop_assert!((y.value - judge.value).abs() < 1e-14 * scale);
        for k in 0..3 {
            prop_assert!((y.first[k] - judge.gradient[k]).abs() < 1e-14 * scale);
            prop_assert!((y.second[k] - judge.hessian.unwrap()[k][k]).abs() < 1e-13 * scale);
        }
        prop_assert!(y.first[3..].iter().chain(&y.second[3..]).all(|&lane| lane == 0.0));
    }

    #[test]
    fn closed_forms_agree_with_dual_numbers(
        strain in 0.001..2.0_f64,
        rate in 0.01..1e6_f64,
        temperature in 0.01..0.99_f64,
        compression in -0.2..0.6_f64,
        energy in 0.0..2e10_f64,
    ) {
        let x = [792.0, 510.0, 0.014, 0.26, 1.03];
        let steel = JohnsonCook::new(strain, rate, temperature);
        compare(&steel.expansion(&x), &forward(&steel, &x), &x, 1e-13)?;
        let (value, first, second) = steel.diagonal(&x);
        let expansion = steel.expansion(&x);
        prop_assert!((value / expansion.value - 1.0).abs() < 1e-14);
        for k in 0..5 {
            prop_assert!((first[k] - expansion.gradient[k]).abs() <= 1e-13 * first[k].abs());
            prop_assert!((second[k] - expansion.hessian.unwrap()[k][k]).abs() <= 1e-13 * second[k].abs());
        }

        let x = [1.49, 0.1, 0.05, 2.17, 0.46];
        let state = MieGruneisenState { bulk_modulus: 1.6e11, compression, energy };
        let shock = MieGruneisen::new(state);
        compare(&shock.expansion(&x), &forward(&shock, &x), &x, 1e-12)?;
        let (_, first, second) = shock.diagonal(&x);
        let expansion = shock.expansion(&x);
        for k in 0..5 {
            prop_assert!((first[k] - expansion.gradient[k]).abs() <= 1e-12 * expansion.value.abs().max(first[k].abs()));
            prop_assert!((second[k] - expansion.hessian.unwrap()[k][k]).abs() <= 1e-12 * second[k].abs());
        }
    }
}

/// Chen et al. 2019, eq 34-35: what is printed and what is right, at a strain of 0.1, a rate of 1000 and T* = 0.2.
#[test]
fn the_derivatives_of_johnson_and_cook_are_not_the_printed_ones() {
    let (strain, rate, temperature) = (0.1_f64, 1e3_f64, 0.2_f64);
    let x = [792.0, 510.0, 0.014, 0.26, 1.03];
    let [a, b, c, n, m] = x;
    let steel = JohnsonCook::new(strain, rate, temperature);
    let judge = forward(&steel, &x).hessian.unwrap();
    let ours = steel.expansion(&x).hessian.unwrap();
    let (ln_e, ln_r, ln_t) = (strain.ln(), rate.ln(), temperature.ln());
    let (e_n, t_m) = (strain.powf(n), temperature.powf(m));
    let (c1, c2, c3) = (a + b * e_n, 1.0 + c * ln_r, 1.0 - t_m);
    // (row, column, right, printed): the second derivatives by n and m, and C5, C4, C6 of eq 35 in their factors.
    let entries = [
        (3, 3, b * e_n * c2 * c3 * ln_e * ln_e, 0.0),
        (4, 4, -c1 * c2 * t_m * ln_t * ln_t, 0.0),
        (2, 3, b * e_n * c3 * (ln_e * ln_r), b * e_n * c3 * (strain + rate).ln()),
        (2, 4, -c1 * t_m * (ln_t * ln_r), -c1 * t_m * (temperature + rate).ln()),
        (
            3,
            4,
            -b * e_n * c2 * t_m * (ln_t * ln_e),
            -b * e_n * c2 * t_m * (temperature + strain).ln(),
        ),
    ];
    for (i, j, right, printed) in entries {
        for (name, hessian) in [("closed", &ours), ("dual numbers", &judge)] {
            let value = hessian[i][j];
            assert!((value - right).abs() < 1e-12 * right.abs(), "{name} ({i}, {j}): {value}");
            assert!((value - printed).abs() > 0.1 * right.abs(), "{name} ({i}, {j}): as printed");
        }
    }
    // With independent inputs the printed zeros leave no second-order term in the mean: the shift is -5.93 at a coefficient of variation of 0.15.
    let inputs = RandomVector::independent(x, x.map(|mean| 0.15 * mean)).unwrap();
    let moments = Moments::new(&inputs, &steel.expansion(&x)).unwrap();
    let shift = moments.mean_second_order().unwrap() - moments.mean_first_order();
    assert!((shift + 5.93).abs() < 0.005, "{shift}");
}

#[test]
fn a_kink_is_invisible_to_derivatives_and_noticed_by_sigma_points() {
    // y = |x - 0.8|, x standard normal: seen from 0 a line of slope -1, variance 1. The points at +-sqrt 3 see the slopes
    // -(1.732 + 0.8 - 0.932)/3.464 = -0.46.
    let inputs = RandomVector::independent([0.0], [1.0]).unwrap();
    let at_mean =
        Expansion { value: 0.8, gradient: [-1.0], hessian: Some([[0.0]]), third: Some([[[0.0]]]) };
    let moments = Moments::new(&inputs, &at_mean).unwrap();
    assert_eq!(moments.trust().unwrap().verdict(), Verdict::InPeace);
    let points = SigmaPoints::new(&inputs, |&[x]| (x - 0.8).abs()).unwrap();
    let trust = points.judge(&moments).unwrap();
    assert_eq!(trust.verdict(), Verdict::Warned);
    let slope = 0.8 / 3.0_f64.sqrt();
    assert!((points.along().first[0] + slope).abs() < 1e-15);
}

#[test]
fn sigma_points_are_exact_for_a_sum_of_quadratics() {
    // y = sum a_k t_k + q_k t_k^2/2: mean sum q/2, variance sum a^2 + q^2/2.
    let inputs = RandomVector::independent([0.0; 2], [1.0; 2]).unwrap();
    let points =
        SigmaPoints::new(&inputs, |x| 3.0 * x[0] + 2.0 * x[0] * x[0] - x[1] * x[1]).unwrap();
    assert!((points.mean() - 1.0).abs() < 1e-14);
    assert!((points.variance() - (9.0 + 0.5 * (16.0 + 4.0))).abs() < 1e-13);
}

#[test]
fn kappa_alone_misses_ishigami() {
    struct Ishigami;
    impl Response<3> for Ishigami {
        fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
            x[0].sin() + x[1].sin().squared() * 7.0 + x[2].powi(4) * x[0].sin() * 0.1
        }
    }
    let correlation = [[1.0, 0.3, 0.0], [0.3, 1.0, 0.3], [0.0, 0.3, 1.0]];
    let inputs = RandomVector::new([1.0, 0.8, 1.5], [0.3; 3], correlation).unwrap();
    let moments = |order| {
        let way = ForwardDifferentiation { response: Ishigami, order };
        Moments::new(&inputs, &way.expansion(inputs.mean())).unwrap()
    };
    let blind = moments(HighestOrder::Second).trust().unwrap();
    assert!(blind.curvature_ratio.unwrap() < 0.01);
    assert_eq!(blind.verdict(), Verdict::Unknown);
    let seeing = moments(HighestOrder::Third);
    assert_eq!(seeing.trust().unwrap().verdict(), Verdict::Warned);
    // And rightly: the variance by quadrature is 4.0221.
    assert!(seeing.variance_first_order() / 4.0221 > 1.3);
}

#[test]
fn monte_carlo_raw_and_controlled_agree_and_repeat() {
    let inputs = RandomVector::new([1.0, 0.5], [0.2, 0.1], [[1.0, 0.4], [0.4, 1.0]]).unwrap();
    let exponential = |x: &[f64; 2]| (x[0] + 0.5 * x[1]).exp();
    let value = exponential(inputs.mean());
    let by_hand = Expansion {
        value,
        gradient: [value, 0.5 * value],
        hessian: Some([[value, 0.5 * value], [0.5 * value, 0.25 * value]]),
        third: None,
    };
    let moments = Moments::new(&inputs, &by_hand).unwrap();
    let judge = MonteCarlo { seed: 5, n_samples: 20_000 };
    let found = judge.judge(&inputs, &moments, exponential).unwrap();
    assert_eq!(found, judge.judge(&inputs, &moments, exponential).unwrap());
    assert!(found.surrogate_mean_miss < 4.0 && found.surrogate_variance_miss < 4.0, "{found:?}");
    // v = Var(x1 + x2/2) = 0.04 + 0.0025 + 0.4 * 0.02; y is lognormal.
    let v = 0.04 + 0.0025 + 0.4 * 0.2 * 0.1;
    let mean = (1.25_f64 + 0.5 * v).exp();
    let variance = mean * mean * (v.exp() - 1.0);
    let within = |e: sde_integrators::Estimate, exact: f64| {
        (e.value - exact).abs() < 4.0 * e.standard_error().unwrap()
    };
    assert!(within(found.raw_mean, mean) && within(found.controlled_mean, mean), "{found:?}");
    assert!(
        within(found.raw_variance, variance) && within(found.controlled_variance, variance),
        "{found:?}"
    );
    assert!(found.mean_reduction() > 20.0 && found.variance_reduction() > 4.0, "{found:?}");

    // No logarithm for one sample in fifteen.
    let failed = judge.judge(&inputs, &moments, |x| (x[0] - 0.7).ln());
    assert!(matches!(failed, Err(Error::NonFiniteSample { .. })), "{failed:?}");
}

/// Every operation once.
fn operations<S: Scalar>(x: S, y: S) -> [S; 18] {
    [
        -x,
        x + y,
        x - y,
        x * y,
        x / y,
        x + 2.0,
        x - 2.0,
        x * 2.5,
        x / 2.5,
        x.squared(),
        x.recip(),
        x.sqrt() * y.exp(),
        x.ln() + y.exp_scaled(0.3),
        x.sin() * y.cos(),
        x.powi(3) * y.powi(-2),
        x.powi(0) + y.powi(1),
        x.powf(0.3),
        (x * y + 1.0).ln() / (x - y * 0.1).sqrt(),
    ]
}

#[test]
fn every_operation_has_the_bits_of_the_jet() {
    let gradients = operations(Gradient::variable(1.7, 0), Gradient::variable(0.6, 7));
    let jets = operations(Jet::variable(1.7, 0), Jet::variable(0.6, 7));
    for (number, (gradient, jet)) in gradients.iter().zip(&jets).enumerate() {
        assert_eq!(gradient.value.to_bits(), jet.value.to_bits(), "{number}");
        let bits = |first: &[f64; 8]| first.map(f64::to_bits);
        assert_eq!(bits(&gradient.first), bits(&jet.first), "{number}");
    }
}

#[test]
fn one_sided_differences_are_off_by_half_the_step_times_the_curvature_and_know_none() {
    // y = 3 + 2 t_1 - t_2 + t_1^2 / 2.
    let (d, y) = (0.1, |t: [f64; 2]| 3.0 + 2.0 * t[0] - t[1] + 0.5 * t[0] * t[0]);
    let values = [y([0.0, 0.0]), y([d, 0.0]), y([0.0, d])];
    let slopes = Slopes::<2>::from_half_star(d, &values).unwrap();
    assert!((slopes.first[0] - (2.0 + 0.5 * d)).abs() < 1e-13);
    assert!((slopes.first[1] + 1.0).abs() < 1e-13);
    let inputs = RandomVector::independent([1.0, 1.0], [0.5, 0.5]).unwrap();
    let moments = Moments::from_slopes(&inputs, &slopes).unwrap();
    assert!((moments.variance_first_order() - (2.05_f64.powi(2) + 1.0)).abs() < 1e-12);
    assert!(matches!(moments.mean_second_order(), Err(Error::CurvatureIncomplete { .. })));
    let short = Slopes::<2>::from_half_star(d, &values[..2]).unwrap_err();
    assert!(matches!(short, Error::TooFew { value: 2, limit: 3, .. }));
    assert!(Slopes::<2>::from_half_star(0.0, &values).is_err());
    assert!(Slopes::<2>::from_half_star(d, &[1.0, f64::NAN, 2.0]).is_err());
}

#[test]
fn mistakes_in_derivatives_are_named() {
    let inputs = RandomVector::independent([0.0; 2], [1.0; 2]).unwrap();
    let line = Expansion { value: 0.0, gradient: [1.0, 1.0], hessian: None, third: None };
    let transposed = Expansion { hessian: Some([[0.0, 1.0], [0.0, 0.0]]), ..line };
    let error = Moments::new(&inputs, &transposed).unwrap_err();
    assert!(matches!(error, Error::NotSymmetric { matrix: "Hessian", row: 1, column: 0, .. }));
    let infinite = Expansion { gradient: [1.0, f64::INFINITY], ..line };
    let error = Moments::new(&inputs, &infinite).unwrap_err();
    assert!(matches!(error, Error::NotFinite { quantity: "gradient entry", index: 1, .. }));
    let unknown = Moments::new(&inputs, &line).unwrap().mean_second_order();
    assert!(matches!(unknown, Err(Error::CurvatureIncomplete { .. })), "{unknown:?}");
}
