//! Exponential, logarithm, power, sine and cosine without a branch and with the same bits on every platform.
//!
//! Only `+ - * /` are used, which IEEE 754 fixes to the bit, and no fused multiply-add. A loop over lanes that calls
//! them is compiled for the registers of the function it stands in: that is why they are inlined always.

#![allow(
    clippy::excessive_precision,
    reason = "the coefficients are those of the source, digit by digit"
)]
#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::f64::consts::LN_2;

const LN_2_HIGH: f64 = 6.93147180369123816490e-01;
const LN_2_LOW: f64 = 1.90821492927058770002e-10;
/// The bits of one.
pub(crate) const ONE: u64 = 0x3ff0_0000_0000_0000;
/// `2^52`, in whose binade the last bit is worth one.
const TWO_52: f64 = (1_u64 << 52) as f64;

/// `(k, f)` with `x = 2^k (1 + f)` and `1 + f` in `(sqrt(1/2), sqrt(2))`, for normal, positive, finite `x`.
#[inline(always)]
fn binade(x: f64) -> (f64, f64) {
    /// The bits of `sqrt(1/2)`, rounded down to 20 bits of mantissa.
    const SQRT_HALF: u64 = 0x3fe6_a09e_0000_0000;

    let shifted = x.to_bits().wrapping_add(ONE - SQRT_HALF);
    // A small whole number as a double by its bits: AVX2 has no conversion of 64-bit integers.
    let k = f64::from_bits(TWO_52.to_bits() | shifted >> 52) - (TWO_52 + 1023.0);
    let f = f64::from_bits((shifted & (u64::MAX >> 12)) + SQRT_HALF) - 1.0;
    (k, f)
}

/// The coefficients of `R(z) = L_0 z + .. + L_6 z^7` in `ln(1 + f) = s (2 + R(s^2))`, `s = f/(2 + f)`, for `1 + f` in
/// `(sqrt(1/2), sqrt(2))`. Source: minimax, from fdlibm's `e_log.c`, Sun Microsystems 1993.
const L: [f64; 7] = [
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860511658591e-01,
];

/// `ln x` for normal, positive, finite `x`; error below one unit in the last place. Elsewhere the result means nothing.
///
/// Source: the order of summation of fdlibm's `e_log.c`, Sun Microsystems 1993.
#[inline(always)]
fn ln_normal(x: f64) -> f64 {
    let (k, f) = binade(x);
    let half_square = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (L[1] + w * (L[3] + w * L[5]));
    let odd = z * (L[0] + w * (L[2] + w * (L[4] + w * L[6])));
    let rest = s * (half_square + even + odd) + k * LN_2_LOW;
    k * LN_2_HIGH - ((half_square - rest) - f)
}

/// `-2 ln u` for `K` normal `u` in `(0, 1]`; relative error below three times `2^-52`, which the root of it halves.
///
/// The series of [`ln_normal`], without what that does for the last bit, and summed as a tree: what a loop over lanes
/// costs are operations that wait for others.
#[inline(always)]
pub(crate) fn minus_twice_ln<const K: usize>(u: [f64; K]) -> [f64; K] {
    let parts = u.map(binade);
    let s = parts.map(|(_, f)| f / (2.0 + f));
    let tail = s.map(|s| {
        let z = s * s;
        let w = z * z;
        let low = (L[0] + z * L[1]) + w * (L[2] + z * L[3]);
        z * (low + (w * w) * ((L[4] + z * L[5]) + w * L[6]))
    });
    std::array::from_fn(|i| parts[i].0 * (-2.0 * LN_2) - (s[i] + s[i]) * (2.0 + tail[i]))
}

/// `(sin x, cos x)` for `K` angles in `[-pi/4, pi/4]`; error below one unit in the last place.
///
/// Source: the minimax coefficients of fdlibm's `k_sin.c` and `k_cos.c`, Sun Microsystems 1993.
#[inline(always)]
pub(crate) fn sin_cos<const K: usize>(x: [f64; K]) -> ([f64; K], [f64; K]) {
    const S: [f64; 6] = [
        -1.66666666666666324348e-01,
        8.33333333332248946124e-03,
        -1.98412698298579493134e-04,
        2.75573137070700676789e-06,
        -2.50507602534068634195e-08,
        1.58969099521155010221e-10,
    ];
    const C: [f64; 6] = [
        4.16666666666666019037e-02,
        -1.38888888888741095749e-03,
        2.48015872894767294178e-05,
        -2.75573143513906633035e-07,
        2.08757232129817482790e-09,
        -1.13596475577881948265e-11,
    ];
    let z = x.map(|x| x * x);
    let sin_tail = z.map(|z| sum_of_six(S, z));
    let cos_tail = z.map(|z| sum_of_six(C, z));
    let sin = std::array::from_fn(|i| x[i] + z[i] * x[i] * sin_tail[i]);
    (sin, std::array::from_fn(|i| 1.0 - (0.5 * z[i] - z[i] * z[i] * cos_tail[i])))
}

/// `c_0 + c_1 z + .. + c_5 z^5`, summed as a tree.
#[inline(always)]
fn sum_of_six(c: [f64; 6], z: f64) -> f64 {
    let w = z * z;
    (c[0] + z * c[1]) + w * ((c[2] + z * c[3]) + w * (c[4] + z * c[5]))
}

/// `exp x`; relative error below two units in the last place. Zero below -708, where the result would be denormal,
/// and infinite above 709.43.
///
/// `x = k ln 2 + r` with `|r| <= ln(2)/2`, then `exp r = 1 + 2r/(2 - c)` with `c = r - r^2 P(r^2)`.
/// Source: the minimax coefficients of fdlibm's `e_exp.c`, Sun Microsystems 1993.
#[inline(always)]
#[must_use]
pub fn exp(x: f64) -> f64 {
    const P: [f64; 5] = [
        1.66666666666666019037e-01,
        -2.77777777770155933842e-03,
        6.61375632143793436117e-05,
        -1.65339022054652515390e-06,
        4.13813679705723846039e-08,
    ];
    /// Added and taken away again, it rounds to a whole number, which is then in the lowest bits.
    const ROUND: f64 = 1.5 * TWO_52;

    // What is not a number is neither below nor above, and passes.
    let clamped = if x < -708.0 { -708.0 } else { x };
    let clamped = if clamped > 710.0 { 710.0 } else { clamped };
    let rounded = clamped * std::f64::consts::LOG2_E + ROUND;
    let k = rounded - ROUND;
    let high = clamped - k * LN_2_HIGH;
    let low = k * LN_2_LOW;
    let r = high - low;
    let z = r * r;
    let c = r - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))));
    let y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
    // 2^k by its bits: for k = 1024 they are those of infinity.
    let scaled = y * f64::from_bits(ONE.wrapping_add(rounded.to_bits() << 52));
    if x < -708.0 { 0.0 } else { scaled }
}

/// `ln x`; error below one unit in the last place for normal `x`. Denormal numbers count as zero, of which the
/// logarithm is minus infinity; below zero it is not a number.
#[inline(always)]
#[must_use]
pub fn ln(x: f64) -> f64 {
    // What it is where `x` is not normal and positive: apart, so that nobody waits for it.
    let elsewhere = if x < f64::MIN_POSITIVE { f64::NEG_INFINITY } else { x };
    let elsewhere = if x < 0.0 { f64::NAN } else { elsewhere };
    let there = ln_normal(x);
    if (f64::MIN_POSITIVE..f64::INFINITY).contains(&x) { there } else { elsewhere }
}

/// `x^a` for `x >= 0` and any finite `a` but zero, as `exp(a ln x)`; relative error below `(3 + 2 |a ln x|) 2^-52`:
/// 1e-14 for `|a ln x| <= 20`. Denormal `x` counts as zero; below zero the result is not a number.
///
/// It has no branch, so that a loop over lanes is compiled for the widest registers; [`f64::powf`] is a call for each.
/// The price is the error, which the platform's function keeps below one unit in the last place.
///
/// ```
/// let x: f64 = 0.3;
/// assert!((sde_integrators::power(x, 0.35) / x.powf(0.35) - 1.0).abs() < 1e-15);
/// ```
#[inline(always)]
#[must_use]
pub fn power(x: f64, a: f64) -> f64 {
    exp(a * ln(x))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    /// The platform's functions are right to one unit in the last place, ours to one: two together.
    #[test]
    fn logarithm_sine_and_cosine_agree_with_the_platform_to_two_units_in_the_last_place() {
        let n = 20_011;
        for i in 1..=n {
            let fraction = f64::from(i) / f64::from(n);
            for u in [fraction, fraction * fraction * 1e-3, fraction * 1e-15, 1.0 - fraction * 1e-9]
            {
                let expected = u.ln();
                assert!((ln(u) - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(), "ln({u})");
                let [twice] = minus_twice_ln([u]);
                let bound = 3.0 * f64::EPSILON * twice;
                assert!((twice + 2.0 * expected).abs() <= bound, "-2 ln({u})");
            }
            let x = (2.0 * fraction - 1.0) * FRAC_PI_4;
            let (([sin], [cos]), (expected_sin, expected_cos)) = (sin_cos([x]), x.sin_cos());
            assert!(
                (sin - expected_sin).abs() <= 2.0 * f64::EPSILON * expected_sin.abs(),
                "sin({x})"
            );
            assert!((cos - expected_cos).abs() <= 2.0 * f64::EPSILON * expected_cos, "cos({x})");
        }
        assert!(ln(1.0).abs() <= 0.0);
    }

    #[test]
    fn the_exponential_agrees_with_the_platform_to_three_units_in_the_last_place() {
        for i in -70_799..=70_943 {
            let x = f64::from(i) * 0.01;
            let expected = x.exp();
            assert!((exp(x) - expected).abs() <= 3.0 * f64::EPSILON * expected, "exp({x})");
        }
    }

    #[test]
    fn the_power_keeps_its_stated_error() {
        for i in 1..=4_000 {
            let x = 10.0_f64.powf(f64::from(i - 2_000) * 0.01);
            for a in [0.35, 0.65, 1.0 / 0.65, 2.0, -0.8, -1.25] {
                let expected = x.powf(a);
                let bound = (4.0 + 2.0 * (a * x.ln()).abs()) * f64::EPSILON;
                assert!((power(x, a) / expected - 1.0).abs() <= bound, "{x}^{a}");
            }
        }
    }

    #[test]
    fn the_ends_of_the_numbers_are_kept() {
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
        assert!(same(power(0.0, 0.35), 0.0) && power(0.0, -0.8).is_infinite());
        assert!(power(f64::INFINITY, 0.35).is_infinite() && same(power(f64::INFINITY, -1.0), 0.0));
        assert!(power(f64::NAN, 0.35).is_nan() && power(-1.0, 0.35).is_nan());
        assert!(exp(f64::NAN).is_nan() && exp(1e9).is_infinite() && same(exp(-1e9), 0.0));
        assert!(same(exp(0.0), 1.0) && same(exp(f64::NEG_INFINITY), 0.0));
        assert!(ln(0.0).is_infinite() && ln(f64::INFINITY).is_infinite() && ln(-1.0).is_nan());
    }
}
