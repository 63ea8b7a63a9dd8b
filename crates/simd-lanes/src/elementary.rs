//! Branch-free exponential, logarithm, power, sine and cosine; results are bitwise identical on every platform.
//!
//! They use only `+ - * /`, whose results IEEE 754 defines exactly, and no fused multiply-add. A loop over lanes that
//! calls them is compiled for the registers of the function that contains it, so they are `#[inline(always)]`.

#![allow(
    clippy::excessive_precision,
    reason = "the coefficients are those of the source, digit by digit"
)]
#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::f64::consts::LN_2;

use crate::arrays::{from_fn, map};
use crate::numbers::{Lanes, Mask};

const LN_2_HIGH: f64 = 6.93147180369123816490e-01;
const LN_2_LOW: f64 = 1.90821492927058770002e-10;
/// Bit pattern of one.
pub(crate) const ONE: u64 = 0x3ff0_0000_0000_0000;
/// Bit pattern of `sqrt(1/2)`, rounded down to 20 bits of mantissa.
pub(crate) const SQRT_HALF: u64 = 0x3fe6_a09e_0000_0000;
/// `2^52`: in its binade the last bit has the value one.
pub(crate) const TWO_52: f64 = (1_u64 << 52) as f64;

/// `(k, f)` with `x = 2^k (1 + f)` and `1 + f` in `(sqrt(1/2), sqrt(2))`, for normal, positive, finite `x`.
#[inline(always)]
pub(crate) fn binade(x: f64) -> (f64, f64) {
    let shifted = x.to_bits().wrapping_add(ONE - SQRT_HALF);
    // Converts a small integer to a double through its bits: AVX2 has no conversion of 64-bit integers.
    let k = f64::from_bits(TWO_52.to_bits() | shifted >> 52) - (TWO_52 + 1023.0);
    let f = f64::from_bits((shifted & (u64::MAX >> 12)) + SQRT_HALF) - 1.0;
    (k, f)
}

/// Minimax coefficients of `R(z)` in the series of `ln(1 + f)`.
///
/// `R(z) = L_0 z + .. + L_6 z^7` in `ln(1 + f) = s (2 + R(s^2))`, `s = f/(2 + f)`, for `1 + f` in
/// `(sqrt(1/2), sqrt(2))`. Source: fdlibm's `e_log.c`, Sun Microsystems 1993.
const L: [f64; 7] = [
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860511658591e-01,
];

/// `ln x` for normal, positive, finite `x`; error below one unit in the last place.
///
/// For other `x` the result is arbitrary.
///
/// Source: the order of summation of fdlibm's `e_log.c`, Sun Microsystems 1993.
#[inline(always)]
fn ln_normal<N: Binary64>(x: N) -> N {
    let (k, f) = x.binade();
    let half_square = x.splat(0.5) * f * f;
    let s = f / (x.splat(2.0) + f);
    let z = s * s;
    let w = z * z;
    let even = w * (x.splat(L[1]) + w * (x.splat(L[3]) + w * x.splat(L[5])));
    let odd = z * (x.splat(L[0]) + w * (x.splat(L[2]) + w * (x.splat(L[4]) + w * x.splat(L[6]))));
    let rest = s * (half_square + even + odd) + k * x.splat(LN_2_LOW);
    k * x.splat(LN_2_HIGH) - ((half_square - rest) - f)
}

/// `-2 ln u` for `K` normal `u` in `(0, 1]`; relative error below `3 * 2^-52`, which its square root halves.
///
/// It is the squared radius of the Box-Muller transform. The series is that of [`ln`] without the steps that round the
/// last bit correctly; it is summed as a tree to shorten the chain of dependent operations.
///
/// ```
/// assert_eq!(simd_lanes::minus_twice_ln([1.0, 0.5]), [0.0, 2.0 * 2.0_f64.ln()]);
/// ```
#[inline(always)]
#[must_use]
pub fn minus_twice_ln<const K: usize>(u: [f64; K]) -> [f64; K] {
    let parts = map(u, binade);
    let s = map(parts, |(_, f)| f / (2.0 + f));
    let tail = map(s, |s| {
        let z = s * s;
        let w = z * z;
        let low = (L[0] + z * L[1]) + w * (L[2] + z * L[3]);
        z * (low + (w * w) * ((L[4] + z * L[5]) + w * L[6]))
    });
    from_fn(|i| parts[i].0 * (-2.0 * LN_2) - (s[i] + s[i]) * (2.0 + tail[i]))
}

/// `(sin x, cos x)` for `K` angles in `[-pi/4, pi/4]`; error below one unit in the last place.
///
/// Reduce larger angles first: beyond `pi/4` the error grows like the first omitted term.
///
/// Source: the minimax coefficients of fdlibm's `k_sin.c` and `k_cos.c`, Sun Microsystems 1993.
///
/// ```
/// let ([sin], [cos]) = simd_lanes::sin_cos([0.5]);
/// assert!((sin - 0.5_f64.sin()).abs() < 2e-16 && (cos - 0.5_f64.cos()).abs() < 2e-16);
/// ```
#[inline(always)]
#[must_use]
pub fn sin_cos<const K: usize>(x: [f64; K]) -> ([f64; K], [f64; K]) {
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
    let z = map(x, |x| x * x);
    let sin_tail = map(z, |z| sum_of_six(S, z));
    let cos_tail = map(z, |z| sum_of_six(C, z));
    let sin = from_fn(|i| x[i] + z[i] * x[i] * sin_tail[i]);
    (sin, from_fn(|i| 1.0 - (0.5 * z[i] - z[i] * z[i] * cos_tail[i])))
}

/// Evaluates `c_0 + c_1 z + .. + c_5 z^5` as a summation tree.
#[inline(always)]
fn sum_of_six(c: [f64; 6], z: f64) -> f64 {
    let w = z * z;
    (c[0] + z * c[1]) + w * ((c[2] + z * c[3]) + w * (c[4] + z * c[5]))
}

/// What exponential and logarithm need to know of the bits of a number, or of the numbers in the lanes of a register.
pub(crate) trait Binary64: Lanes<Number = f64> {
    /// `(k, f)` with `x = 2^k (1 + f)` and `1 + f` in `(sqrt(1/2), sqrt(2))`, for normal, positive, finite `x`.
    fn binade(self) -> (Self, Self);
    /// `2^k` for `k` from -1022 to 1024 (infinity), given [`ROUND`] `+ k`.
    fn power_of_two(self) -> Self;
}

impl Binary64 for f64 {
    #[inline(always)]
    fn binade(self) -> (f64, f64) {
        binade(self)
    }
    #[inline(always)]
    fn power_of_two(self) -> f64 {
        power_of_two(self)
    }
}

/// Adding and subtracting it rounds to an integer, which the lowest bits then hold.
const ROUND: f64 = 1.5 * TWO_52;

/// `2^k` from its bit pattern; for `k = 1024` the pattern is that of infinity.
#[inline(always)]
pub(crate) fn power_of_two(rounded: f64) -> f64 {
    f64::from_bits(ONE.wrapping_add(rounded.to_bits() << 52))
}

/// `exp x`; relative error below two units in the last place.
///
/// Returns zero below -708, where the result would be denormal, infinity above 709.43, and NaN for NaN.
#[inline(always)]
#[must_use]
pub fn exp(x: f64) -> f64 {
    exp_of(x)
}

/// The same of each lane.
///
/// The argument is reduced to `x = k ln 2 + r` with `|r| <= ln(2)/2`; then `exp r = 1 + 2r/(2 - c)` with
/// `c = r - r^2 P(r^2)`. Source: the minimax coefficients of fdlibm's `e_exp.c`, Sun Microsystems 1993.
#[inline(always)]
pub(crate) fn exp_of<N: Binary64>(x: N) -> N {
    const P: [f64; 5] = [
        1.66666666666666019037e-01,
        -2.77777777770155933842e-03,
        6.61375632143793436117e-05,
        -1.65339022054652515390e-06,
        4.13813679705723846039e-08,
    ];
    // NaN compares false with both limits and passes through.
    let clamped = N::select(x.less(x.splat(-708.0)), x.splat(-708.0), x);
    let clamped = N::select(x.splat(710.0).less(clamped), x.splat(710.0), clamped);
    let rounded = clamped * x.splat(std::f64::consts::LOG2_E) + x.splat(ROUND);
    let k = rounded - x.splat(ROUND);
    let high = clamped - k * x.splat(LN_2_HIGH);
    let low = k * x.splat(LN_2_LOW);
    let r = high - low;
    let z = r * r;
    let even = x.splat(P[0])
        + z * (x.splat(P[1]) + z * (x.splat(P[2]) + z * (x.splat(P[3]) + z * x.splat(P[4]))));
    let rest = r - z * even;
    let y = x.splat(1.0) - ((low - (r * rest) / (x.splat(2.0) - rest)) - high);
    let scaled = y * rounded.power_of_two();
    N::select(x.less(x.splat(-708.0)), x.splat(0.0), scaled)
}

/// `ln x`; error below one unit in the last place for normal `x`.
///
/// Denormal numbers count as zero, whose logarithm is minus infinity; the result is NaN below zero.
#[inline(always)]
#[must_use]
pub fn ln(x: f64) -> f64 {
    ln_of(x)
}

/// The same of each lane.
#[inline(always)]
pub(crate) fn ln_of<N: Binary64>(x: N) -> N {
    // The result for `x` that is not normal and positive, computed independently so that no operation waits for it.
    let elsewhere = N::select(x.less(x.splat(f64::MIN_POSITIVE)), x.splat(f64::NEG_INFINITY), x);
    let elsewhere = N::select(x.less(x.splat(0.0)), x.splat(f64::NAN), elsewhere);
    let is_normal = x.at_least(x.splat(f64::MIN_POSITIVE)).and(x.less(x.splat(f64::INFINITY)));
    N::select(is_normal, ln_normal(x), elsewhere)
}

/// `exp x` of `f64`, rounded.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "it rounds")]
pub(crate) fn exp_rounded(x: f32) -> f32 {
    exp(x.into()) as f32
}

/// `ln x` of `f64`, rounded.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "it rounds")]
pub(crate) fn ln_rounded(x: f32) -> f32 {
    ln(x.into()) as f32
}

/// `x^a` for `x >= 0` and finite nonzero `a`, as `exp(a ln x)`.
///
/// The relative error is below `(3 + 2 |a ln x|) 2^-52`: 1e-14 for `|a ln x| <= 20`. Denormal `x` counts as zero; the
/// result is NaN below zero.
///
/// [`f64::powf`] keeps its error below one unit in the last place, but costs a function call for each number.
///
/// ```
/// let x: f64 = 0.3;
/// assert!((simd_lanes::power(x, 0.35) / x.powf(0.35) - 1.0).abs() < 1e-15);
/// ```
#[inline(always)]
#[must_use]
pub fn power(x: f64, a: f64) -> f64 {
    exp(a * ln(x))
}
