//! Errors in units of the last place, against a reference of about 100 bits.

use std::f64::consts::FRAC_PI_4;

use crate::reference::{Double, reference_exp, reference_ln, reference_sin_cos};
use simd_lanes::{exp, ln, minus_twice_ln, power, sin_cos};

/// The largest error over points with bits of every kind.
fn worst(points: impl Iterator<Item = f64>, error: impl Fn(f64) -> f64) -> f64 {
    points
        .map(error)
        .fold(0.0, |worst, error| if error > worst || error.is_nan() { error } else { worst })
}

/// `n` equally spaced points over a range.
fn over(low: f64, high: f64, n: u32) -> impl Iterator<Item = f64> {
    (0..=n).map(move |k| low + (high - low) * (f64::from(k) / f64::from(n)))
}

/// Positive numbers of every binade from `2^-900` to `2^900`.
fn binades() -> impl Iterator<Item = f64> {
    over(1.0, 2.0, 101).flat_map(|x| (-900..900).map(move |k| x * 2.0_f64.powi(k)))
}

#[test]
fn reference_is_right_beyond_the_last_place() {
    // e^-1 = 0.36787944117144232159552377016146 (DLMF 4.2.11), ln 2 = 0.693147180559945309417232121458176568 (4.2.14).
    let rest = |value: Double, high: f64, low: f64| ((value.0 - high) + (value.1 - low)).abs();
    let e = reference_exp(Double(-1.0, 0.0));
    assert!(rest(e, 0.367_879_441_171_442_33, -1.242_875_367_278_836_3e-17) < 1e-28);
    assert!(rest(reference_ln(2.0), std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17) < 1e-28);
    // sin^2 + cos^2 = 1
    let (sin, cos) = reference_sin_cos(0.7);
    assert!(rest(sin.times(sin).plus(cos.times(cos)), 1.0, 0.0) < 1e-30);
}

#[test]
fn exponential_errs_by_less_than_two_units() {
    let error = |x| reference_exp(Double(x, 0.0)).ulps(exp(x));
    let worst = worst(over(-660.0, 709.4, 100_003).chain(over(-1.0, 1.0, 20_011)), error);
    assert!((0.5..2.0).contains(&worst), "{worst}");
}

#[test]
fn logarithm_errs_by_less_than_one_unit() {
    let error = |x| reference_ln(x).ulps(ln(x));
    let worst =
        worst(binades().chain(over(0.5, 2.0, 20_012)).filter(|&x| (x - 1.0).abs() > 0.0), error);
    assert!((0.5..1.0).contains(&worst), "{worst}");
    assert_eq!(ln(1.0).to_bits(), 0.0_f64.to_bits());
}

#[test]
fn twice_the_logarithm_errs_by_less_than_its_stated_bound() {
    let error = |u| {
        let exact = reference_ln(u).times(Double(-2.0, 0.0));
        let [twice] = minus_twice_ln([u]);
        ((twice - exact.0) - exact.1).abs() / (exact.0 * f64::EPSILON)
    };
    let below_one = binades().filter(|&u| u < 1.0).chain(over(1e-3, 1.0 - 1e-9, 40_009));
    let worst = worst(below_one, error);
    assert!((0.5..3.0).contains(&worst), "{worst}");
    assert!(minus_twice_ln([1.0])[0].abs() <= 0.0);
}

#[test]
fn sine_and_cosine_err_by_less_than_one_unit() {
    let angles = || over(-FRAC_PI_4, FRAC_PI_4, 40_008).filter(|&x| x.abs() > 0.0);
    let sine = worst(angles(), |x| reference_sin_cos(x).0.ulps(sin_cos([x]).0[0]));
    let cosine = worst(angles(), |x| reference_sin_cos(x).1.ulps(sin_cos([x]).1[0]));
    assert!((0.5..1.0).contains(&sine) && (0.5..1.0).contains(&cosine), "{sine} {cosine}");
}

#[test]
fn power_keeps_its_stated_error() {
    for a in [0.35, 0.65, 1.0 / 0.65, 2.0, -0.8, -1.25] {
        for x in over(-20.0, 20.0, 4_001).map(|k| 10.0_f64.powf(k)) {
            let logarithm = reference_ln(x).times(Double(a, 0.0));
            let exact = reference_exp(logarithm);
            let error = ((power(x, a) - exact.0) - exact.1).abs() / exact.0;
            assert!(error <= (3.0 + 2.0 * logarithm.0.abs()) * f64::EPSILON, "{x}^{a}: {error}");
        }
    }
}

#[test]
fn special_values_are_those_of_the_documentation() {
    let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
    assert!(same(power(0.0, 0.35), 0.0) && power(0.0, -0.8).is_infinite());
    assert!(power(f64::INFINITY, 0.35).is_infinite() && same(power(f64::INFINITY, -1.0), 0.0));
    assert!(power(f64::NAN, 0.35).is_nan() && power(-1.0, 0.35).is_nan());
    assert!(same(power(5e-324, 0.35), 0.0));
    assert!(exp(f64::NAN).is_nan() && exp(1e9).is_infinite() && same(exp(-1e9), 0.0));
    assert!(same(exp(0.0), 1.0) && same(exp(f64::NEG_INFINITY), 0.0));
    assert!(exp(709.42).is_finite() && exp(709.44).is_infinite());
    assert!(exp(-707.9) >= f64::MIN_POSITIVE && same(exp(-708.1), 0.0));
    assert!(same(ln(0.0), f64::NEG_INFINITY) && same(ln(5e-324), f64::NEG_INFINITY));
    assert!(same(ln(f64::INFINITY), f64::INFINITY) && ln(-1.0).is_nan() && ln(f64::NAN).is_nan());
}
