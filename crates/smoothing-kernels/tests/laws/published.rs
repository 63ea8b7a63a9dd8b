//! Normalisations and values of the kernels as their sources print them, and the error of the exponential in the Gaussian.

use smoothing_kernels::{
    CubicSpline, Kernel, Lucy, QuarticSpline, QuinticSpline, TruncatedGaussian, WendlandC2,
    WendlandC4, WendlandC6,
};
use std::f64::consts::PI;

use crate::exponential::exponential;
use crate::reference::{Double, reference_exp};

/// Asserts normalisations from one dimension on. Sums over the pieces of a spline cancel to about a tenth of their largest term.
fn assert_normalised<K>(kernel: &K, published: [f64; 3])
where
    K: Kernel<1> + Kernel<2> + Kernel<3>,
{
    let ours = [
        Kernel::<1>::normalisation(kernel),
        Kernel::<2>::normalisation(kernel),
        Kernel::<3>::normalisation(kernel),
    ];
    for (ours, published) in ours.into_iter().zip(published) {
        assert!((ours / published - 1.0).abs() < 1e-14, "{ours} {published}");
    }
}

#[test]
fn normalisations_are_the_published_ones() {
    // Canor & Denoel 2013, eq 9: alpha_2, alpha_3, alpha_4; alpha_1 = 1/(2 * 2/5).
    assert_normalised(&Lucy, [5.0 / 4.0, 5.0 / PI, 105.0 / (16.0 * PI)]);
    let alpha_4 = Kernel::<4>::normalisation(&Lucy);
    assert!((alpha_4 / (28.0 / (PI * PI)) - 1.0).abs() < 1e-14, "{alpha_4}");
    // Monaghan & Lattanzio 1985.
    assert_normalised(&CubicSpline, [2.0 / 3.0, 10.0 / (7.0 * PI), 1.0 / PI]);
    // Dehnen & Aly 2012, table 1: the factors of the sums of truncated powers, whose peaks are 14.375 and 66.
    let quartic = [1.0 / 24.0, 96.0 / (1199.0 * PI), 1.0 / (20.0 * PI)];
    assert_normalised(&QuarticSpline, quartic.map(|factor| 14.375 * factor));
    let quintic = [1.0 / 120.0, 7.0 / (478.0 * PI), 1.0 / (120.0 * PI)];
    assert_normalised(&QuinticSpline, quintic.map(|factor| 66.0 * factor));
    // The same table, there with the support of 2 h as the unit of length.
    let in_h = |[one, two, three]: [f64; 3]| [one / 2.0, two / 4.0, three / 8.0];
    assert_normalised(&WendlandC2, in_h([5.0 / 4.0, 7.0 / PI, 21.0 / (2.0 * PI)]));
    assert_normalised(&WendlandC4, in_h([3.0 / 2.0, 9.0 / PI, 495.0 / (32.0 * PI)]));
    assert_normalised(&WendlandC6, in_h([55.0 / 32.0, 78.0 / (7.0 * PI), 1365.0 / (64.0 * PI)]));
}

#[test]
fn normalisation_of_the_gaussian_is_elementary_in_even_dimensions() {
    // P(1, x) = 1 - e^-x; P(2, x) = 1 - e^-x (1 + x); P(3, x) = 1 - e^-x (1 + x + x^2/2), DLMF 8.4.9.
    let tail = (-9.0_f64).exp();
    let ours = [
        Kernel::<2>::normalisation(&TruncatedGaussian),
        Kernel::<4>::normalisation(&TruncatedGaussian),
        Kernel::<6>::normalisation(&TruncatedGaussian),
        Kernel::<1>::normalisation(&TruncatedGaussian),
    ];
    let elementary = [
        1.0 / (PI * (1.0 - tail)),
        1.0 / (PI.powi(2) * (1.0 - tail * 10.0)),
        1.0 / (PI.powi(3) * (1.0 - tail * 50.5)),
        // erf(3) = 0.99997790950300141455862722387 (Abramowitz & Stegun, table 7.1).
        1.0 / (PI.sqrt() * 0.999_977_909_503_001_4),
    ];
    for (ours, elementary) in ours.into_iter().zip(elementary) {
        assert!((ours / elementary - 1.0).abs() < 1e-14, "{ours} {elementary}");
    }
}

fn assert_values<K: Kernel<D>, const D: usize>(kernel: &K, values: &[(f64, f64)]) {
    for &(q, expected) in values {
        let shape = kernel.shape(q);
        assert!((shape - expected).abs() < 1e-15, "{D} dimensions at q = {q}: {shape} {expected}");
    }
}

#[test]
fn values_are_the_published_ones() {
    // (1 + 3q)(1 - q)^3 = 1 - 6 q^2 + 8 q^3 - 3 q^4.
    assert_values::<_, 2>(&Lucy, &[(0.5, 5.0 / 16.0)]);
    // (5/2-q)^4 - 5 (3/2-q)^4: 16 - 5 at q = 1/2, 1 at 3/2.
    let of_peak = |value: f64| value / 14.375;
    assert_values::<_, 3>(&QuarticSpline, &[(0.5, of_peak(11.0)), (1.5, of_peak(1.0)), (2.5, 0.0)]);
    // (3-q)^5 - 6 (2-q)^5: 32 - 6 at q = 1, 1 at 2.
    assert_values::<_, 3>(&QuinticSpline, &[(1.0, 26.0 / 66.0), (2.0, 1.0 / 66.0), (3.0, 0.0)]);
    // At q = 1: (1/2)^m (1 + m/2), where m grows with every second dimension.
    assert_values::<_, 1>(&WendlandC2, &[(1.0, 2.5 / 8.0)]);
    assert_values::<_, 2>(&WendlandC2, &[(1.0, 3.0 / 16.0)]);
    assert_values::<_, 3>(&WendlandC2, &[(1.0, 3.0 / 16.0)]);
    assert_values::<_, 4>(&WendlandC2, &[(1.0, 3.5 / 32.0)]);
    assert_values::<_, 6>(&WendlandC2, &[(1.0, 4.0 / 64.0)]);
    // Dehnen & Aly 2012, table 1, at x = 1/2.
    assert_values::<_, 1>(&WendlandC4, &[(1.0, 5.5 / 32.0)]);
    assert_values::<_, 3>(&WendlandC4, &[(1.0, (4.0 + 35.0 / 12.0) / 64.0)]);
    assert_values::<_, 1>(&WendlandC6, &[(1.0, (4.5 + 4.75 + 21.0 / 8.0) / 128.0)]);
    assert_values::<_, 3>(&WendlandC6, &[(1.0, (5.0 + 6.25 + 4.0) / 256.0)]);
}

#[test]
fn pieces_of_the_cubic_spline_meet_at_one_with_value_and_both_derivatives() {
    // From either side: w = 1/4, w' = -3/4, w'' = 3/2 at q = 1.
    let (below, above) = (1.0 - 1e-6, 1.0 + 1e-6);
    let derivative = |q| Kernel::<3>::shape_derivative(&CubicSpline, q);
    for q in [below, 1.0, above] {
        assert!((Kernel::<3>::shape(&CubicSpline, q) - 0.25).abs() < 1e-6);
        assert!((derivative(q) + 0.75).abs() < 2e-6);
    }
    assert!(((derivative(above) - derivative(below)) / (above - below) - 1.5).abs() < 1e-5);
}

/// Error of the exponential in units of the last place of the result.
fn ulps(x: f64) -> f64 {
    reference_exp(Double(x, 0.0)).ulps(exponential(x))
}

#[test]
fn exponential_errs_by_less_than_one_unit_in_the_last_place() {
    // The Gaussian's whole range, 200,001 points; an odd step in bits, so that every pattern of the low ones occurs.
    let n = 200_000_u32;
    let worst = (0..=n)
        .map(|k| {
            let x = -9.0 * f64::from(k) / f64::from(n);
            ulps(x).max(ulps((x * 0.999_999_3).max(-9.0)))
        })
        .fold(0.0, f64::max);
    assert!((0.5..0.9).contains(&worst), "{worst}");
    assert_eq!(exponential(-0.0).to_bits(), 1.0_f64.to_bits());
}

#[test]
fn gaussian_is_that_exponential() {
    for k in 0..3000 {
        let q = 0.001 * f64::from(k);
        let shape = Kernel::<2>::shape(&TruncatedGaussian, q);
        assert_eq!(shape.to_bits(), exponential(-(q * q)).to_bits());
    }
}
