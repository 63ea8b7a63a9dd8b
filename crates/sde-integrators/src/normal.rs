//! Standard normals from uniform words, with the same bits on every platform.
//!
//! The logarithm, sine and cosine are here, because the platform's are not the same everywhere. Only `+ - * /` and
//! `sqrt` are used, which IEEE 754 fixes to the bit, and no fused multiply-add.

#![allow(
    clippy::excessive_precision,
    reason = "the coefficients are those of the source, digit by digit"
)]
#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::f64::consts::FRAC_PI_2;

use pulp::Arch;

/// Pairs that are drawn at once: enough for the widest registers, few enough that a short path wastes little.
pub(crate) const LANES: usize = 16;

/// `2^-53`, the spacing of the radial uniforms: they lie in `2^-53, 2 * 2^-53, .., 1`.
const SPACING: f64 = 1.0 / (1_u64 << 53) as f64;

/// Two independent standard normals from two words, by Box and Muller,
///
/// $$ z_0 = \sqrt{-2 \ln u} \cos\theta, \qquad z_1 = \sqrt{-2 \ln u} \sin\theta . $$
///
/// `u` has 53 bits and is never zero, `theta` has 54 bits and is symmetric about both axes, so that the mean of each
/// normal over all words is exactly zero. The largest value is `sqrt(106 ln 2) = 8.57`: a tail of 1e-17 is missing.
///
/// Source: Box and Muller 1958, A note on the generation of random normal deviates.
#[inline(always)]
pub(crate) fn normal_pair(radial: u64, angular: u64) -> [f64; 2] {
    let u = ((radial >> 11) + 1) as f64 * SPACING;
    let radius = (-2.0 * ln(u)).sqrt();
    // The two highest bits choose the quadrant, the next 52 the angle within it, from -pi/4 to pi/4.
    let fraction = (((angular << 2) >> 12) as f64 + 0.5) * (2.0 * SPACING) - 0.5;
    let (sin, cos) = sin_cos(fraction * FRAC_PI_2);
    // (c, s) -> (-s, c) per quarter turn, without a branch: a random one would be mispredicted.
    let quadrant = angular >> 62;
    let swap = (quadrant & 1).wrapping_neg() & (cos.to_bits() ^ sin.to_bits());
    let c = f64::from_bits(cos.to_bits() ^ swap ^ ((quadrant ^ quadrant << 1) & 2) << 62);
    let s = f64::from_bits(sin.to_bits() ^ swap ^ (quadrant & 2) << 62);
    [radius * c, radius * s]
}

/// [`normal_pair`] in every lane, by the widest registers that the machine has. The bits are those of the scalar
/// function: each lane does the same operations in the same order, none of them fused.
pub(crate) fn normal_pairs(
    arch: Arch,
    radial: &[u64; LANES],
    angular: &[u64; LANES],
) -> [[f64; LANES]; 2] {
    arch.dispatch(
        #[inline(always)]
        || {
            let mut normals = [[0.0; LANES]; 2];
            for lane in 0..LANES {
                let [first, second] = normal_pair(radial[lane], angular[lane]);
                normals[0][lane] = first;
                normals[1][lane] = second;
            }
            normals
        },
    )
}

/// `ln x` for normal, positive `x`; error below one unit in the last place.
///
/// `x = 2^k (1 + f)` with `1 + f` in `(sqrt(1/2), sqrt(2))`, then a polynomial in `s = f/(2 + f)`.
/// Source: the minimax coefficients and the order of summation of fdlibm's `e_log.c`, Sun Microsystems 1993.
#[inline(always)]
fn ln(x: f64) -> f64 {
    const LN_2_HIGH: f64 = 6.93147180369123816490e-01;
    const LN_2_LOW: f64 = 1.90821492927058770002e-10;
    const L: [f64; 7] = [
        6.666666666666735130e-01,
        3.999999999940941908e-01,
        2.857142874366239149e-01,
        2.222219843214978396e-01,
        1.818357216161805012e-01,
        1.531383769920937332e-01,
        1.479819860511658591e-01,
    ];
    /// The bits of `sqrt(1/2)`, rounded down to 20 bits of mantissa.
    const SQRT_HALF: u64 = 0x3fe6_a09e_0000_0000;
    const ONE: u64 = 0x3ff0_0000_0000_0000;

    let shifted = x.to_bits().wrapping_add(ONE - SQRT_HALF);
    let k = (shifted >> 52) as f64 - 1023.0;
    let f = f64::from_bits((shifted & (u64::MAX >> 12)) + SQRT_HALF) - 1.0;
    let half_square = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (L[1] + w * (L[3] + w * L[5]));
    let odd = z * (L[0] + w * (L[2] + w * (L[4] + w * L[6])));
    let rest = s * (half_square + even + odd) + k * LN_2_LOW;
    k * LN_2_HIGH - ((half_square - rest) - f)
}

/// `(sin x, cos x)` for `x` in `[-pi/4, pi/4]`; error below one unit in the last place.
///
/// Source: the minimax coefficients of fdlibm's `k_sin.c` and `k_cos.c`, Sun Microsystems 1993.
#[inline(always)]
fn sin_cos(x: f64) -> (f64, f64) {
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
    let z = x * x;
    let sin_tail = S[1] + z * (S[2] + z * (S[3] + z * (S[4] + z * S[5])));
    let sin = x + z * x * (S[0] + z * sin_tail);
    let cos_tail = z * (C[0] + z * (C[1] + z * (C[2] + z * (C[3] + z * (C[4] + z * C[5])))));
    let half = 0.5 * z;
    let head = 1.0 - half;
    let cos = head + (((1.0 - head) - half) + z * cos_tail);
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The platform's functions are right to one unit in the last place, ours to one: two together.
    #[test]
    fn the_elementary_functions_agree_with_the_platform_to_two_units_in_the_last_place() {
        let n = 20_011;
        for i in 1..=n {
            let fraction = f64::from(i) / f64::from(n);
            for u in [
                fraction,
                fraction * fraction * 1e-3,
                fraction * SPACING * 40.0,
                1.0 - fraction * 1e-9,
            ] {
                let expected = u.ln();
                assert!((ln(u) - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(), "ln({u})");
            }
            let x = (fraction - 0.5) * FRAC_PI_2;
            let ((sin, cos), (expected_sin, expected_cos)) = (sin_cos(x), x.sin_cos());
            assert!(
                (sin - expected_sin).abs() <= 2.0 * f64::EPSILON * expected_sin.abs(),
                "sin({x})"
            );
            assert!((cos - expected_cos).abs() <= 2.0 * f64::EPSILON * expected_cos, "cos({x})");
        }
        assert!(ln(1.0).abs() <= 0.0);
    }

    #[test]
    fn every_lane_gives_the_bits_of_the_scalar_function() {
        for start in 0..200_u64 {
            let word = |lane: usize, salt: u64| {
                (start * LANES as u64 + lane as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15 ^ salt)
            };
            let (radial, angular) = (
                std::array::from_fn(|lane| word(lane, 0)),
                std::array::from_fn(|lane| word(lane, 0xabcd_ef01)),
            );
            let lanes = normal_pairs(Arch::new(), &radial, &angular);
            for lane in 0..LANES {
                let scalar = normal_pair(radial[lane], angular[lane]);
                assert_eq!(
                    scalar.map(f64::to_bits),
                    [lanes[0][lane], lanes[1][lane]].map(f64::to_bits)
                );
            }
        }
    }

    #[test]
    fn the_four_quadrants_are_quarter_turns_of_one_another() {
        let words = (0x1234_5678_9abc_def0, 0x0fed_cba9_8765_4321);
        let [mut c, mut s] = normal_pair(words.0, words.1);
        for quadrant in 1..4_u64 {
            let turned = normal_pair(words.0, words.1 | quadrant << 62);
            assert_eq!(turned.map(f64::to_bits), [-s, c].map(f64::to_bits));
            [c, s] = turned;
        }
    }

    #[test]
    fn the_extreme_words_give_finite_normals_within_the_stated_range() {
        let largest = (106.0 * std::f64::consts::LN_2).sqrt() * (1.0 + 1e-14);
        for radial in [0, 1 << 11, u64::MAX] {
            for angular in [0, u64::MAX, 1 << 61, (1 << 62) - 1, 1 << 62, 1 << 63] {
                let pair = normal_pair(radial, angular);
                assert!(pair.iter().all(|z| z.abs() <= largest), "{radial} {angular}: {pair:?}");
            }
        }
    }
}
