//! Branch-free exponential of a nonpositive number, which vectorises in loops.

use core::f64::consts::LOG2_E;

/// The 32 leading bits of `ln 2`: products with integers below 2^20 are exact.
const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);

/// `ln 2` minus its 32 leading bits.
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Adding it to a number of magnitude below 2^51 rounds to an integer, whose bits are then the lowest of the sum.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// `1/2!, 1/4!, .. 1/12!`
const EVEN: [f64; 6] =
    [1.0 / 2.0, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0, 1.0 / 479_001_600.0];

/// `1/3!, 1/5!, .. 1/13!`
const ODD: [f64; 6] = [
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
];

/// `e^x` for `-9 <= x <= 0`, the range of the Gaussian on three smoothing lengths; NaN for NaN.
///
/// $$ e^x = 2^k e^r, \quad k = \lfloor x / \ln 2 \rceil, \quad r = x - k \ln 2, \qquad
///    e^r = 1 + \Bigl( r + r^2 \sum_{n=2}^{13} \frac{r^{n-2}}{n!} \Bigr) $$
///
/// `|r|` is at most `ln 2 / 2`, where the first omitted term is 5e-18 of the sum. Error: below one unit in the last
/// place; the largest at 400,002 points of the range is 0.87. Only additions, products and shifts are used, none
/// fused, so results are bitwise identical for every register width.
#[inline]
pub(crate) fn exponential(x: f64) -> f64 {
    let shifted = x * LOG2_E + ROUNDING;
    let k = shifted - ROUNDING;
    let (high, low) = (x - k * LN_2_HIGH, k * LN_2_LOW);
    let r = high - low;
    // Rounding error of the difference.
    let lost = (high - r) - low;
    let s = r * r;
    let tail = polynomial(&EVEN, s) + r * polynomial(&ODD, s);
    // The lowest 11 bits of the sum hold k; with the exponent bias they are those of 2^k.
    let two_to_k = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    two_to_k * (1.0 + (r + (s * tail + lost)))
}

/// `c_0 + c_1 s + .. + c_5 s^5` by pairs, which depend on each other less than in Horner's rule.
#[inline]
fn polynomial(c: &[f64; 6], s: f64) -> f64 {
    let square = s * s;
    (c[0] + c[1] * s) + square * ((c[2] + c[3] * s) + square * (c[4] + c[5] * s))
}
