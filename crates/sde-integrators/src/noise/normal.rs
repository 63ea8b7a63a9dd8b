//! Standard normals from uniform words, bitwise identical on every platform.
//!
//! Logarithm, sine and cosine are implemented here, because those of platforms differ. Only `+ - * /` and `sqrt` are
//! used, whose results IEEE 754 defines exactly, and no fused multiply-add.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::f64::consts::FRAC_PI_2;

use simd_lanes::{Registers, SimdLevel, Work, minus_twice_ln, sin_cos};

use crate::noise::chacha::{BLOCK_WORDS, blocks};

/// Normals from one block of the cipher: four pairs, each of four words.
pub(crate) const BLOCK_NORMALS: usize = 8;

/// `2^-53`, half the spacing of the uniforms.
const HALF_SPACING: f64 = 1.0 / (1_u64 << 53) as f64;

/// Bit pattern of one.
const ONE: u64 = 1.0_f64.to_bits();

/// Sign bit of a double.
const SIGN: u64 = 1 << 63;

/// Two independent standard normals from two words, by the Box-Muller transform,
///
/// $$ z_0 = \sqrt{-2 \ln u} \cos\theta, \qquad z_1 = \sqrt{-2 \ln u} \sin\theta . $$
///
/// `u` has 52 bits and lies in `(0, 1]`, so it is never zero. `theta` has 54 bits and is symmetric about both axes, so
/// the mean of each normal over all words is exactly zero. The largest value is `sqrt(104 ln 2) = 8.49`: a tail of
/// 2e-17 is missing.
///
/// Source: Box and Muller 1958, A note on the generation of random normal deviates.
#[inline(always)]
pub(crate) fn normal_pair(radial: u64, angular: u64) -> [f64; 2] {
    let ([first], [second]) = normal_pairs([radial], [angular]);
    [first, second]
}

/// [`normal_pair`] for `K` pairs of words: all first normals, all second ones.
///
/// Each stage is a loop of its own over all `K`, which the compiler vectorises on its own.
#[inline(always)]
fn normal_pairs<const K: usize>(radial: [u64; K], angular: [u64; K]) -> ([f64; K], [f64; K]) {
    // The highest 52 bits as the mantissa of a number in [1, 2): exact and without conversion.
    let u = simd_lanes::map(radial, |word| 2.0 - f64::from_bits(ONE | word >> 12));
    // The two highest bits select the quadrant, the next 52 the angle within it, from -pi/4 to pi/4.
    let angle = simd_lanes::map(angular, |word| {
        ((f64::from_bits(ONE | (word << 2) >> 12) - 1.5) + HALF_SPACING) * FRAC_PI_2
    });
    let squares = minus_twice_ln(u);
    let (sin, cos) = sin_cos(angle);
    let radius = simd_lanes::map(squares, f64::sqrt);
    let (mut first, mut second) = ([0.0; K], [0.0; K]);
    for i in 0..K {
        // (c, s) -> (-s, c) per quarter turn, branch-free: a random branch would be mispredicted.
        let (cos, sin) = (cos[i].to_bits(), sin[i].to_bits());
        let is_odd = (angular[i] << 1).cast_signed() < 0;
        let (c, s) = if is_odd { (sin, cos) } else { (cos, sin) };
        first[i] = radius[i] * f64::from_bits(c ^ (angular[i] ^ angular[i] << 1) & SIGN);
        second[i] = radius[i] * f64::from_bits(s ^ angular[i] & SIGN);
    }
    (first, second)
}

/// The eight normals of block `counters[lane]` of stream `streams[lane]`, in every lane.
#[inline(always)]
pub(crate) fn normal_blocks<const L: usize>(
    key: &[u32; 8],
    streams: &[u64; L],
    counters: &[u64; L],
    normals: &mut [[f64; L]; BLOCK_NORMALS],
) {
    let mut words = [[0; L]; BLOCK_WORDS];
    blocks(key, streams, counters, &mut words);
    for pair in 0..BLOCK_NORMALS / 2 {
        let [first, second] = &mut normals[2 * pair..2 * pair + 2] else { continue };
        let [a, b, c, d] = &words[4 * pair..4 * pair + 4] else { continue };
        let radial = simd_lanes::from_fn(|lane| u64::from(a[lane]) | u64::from(b[lane]) << 32);
        let angular = simd_lanes::from_fn(|lane| u64::from(c[lane]) | u64::from(d[lane]) << 32);
        (*first, *second) = normal_pairs(radial, angular);
    }
}

/// Lanes of [`normal_rows`].
pub(crate) const ROW: usize = 32;

/// [`normal_blocks`] of 32 lanes at a level: compiled once, not with each system that needs noise.
///
/// The call costs a few nanoseconds of the 700 that the normals take.
#[inline(never)]
pub(crate) fn normal_rows(
    level: SimdLevel,
    key: &[u32; 8],
    streams: &[u64; ROW],
    counters: &[u64; ROW],
    normals: &mut [[f64; ROW]; BLOCK_NORMALS],
) {
    level.run(NormalRows { key, streams, counters, normals });
}

struct NormalRows<'a> {
    key: &'a [u32; 8],
    streams: &'a [u64; ROW],
    counters: &'a [u64; ROW],
    normals: &'a mut [[f64; ROW]; BLOCK_NORMALS],
}

impl Work<f64> for NormalRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        normal_blocks(self.key, self.streams, self.counters, self.normals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let largest = (104.0 * std::f64::consts::LN_2).sqrt() * (1.0 + 1e-14);
        for radial in [0, 1 << 12, u64::MAX] {
            for angular in [0, u64::MAX, 1 << 61, (1 << 62) - 1, 1 << 62, 1 << 63] {
                let pair = normal_pair(radial, angular);
                assert!(pair.iter().all(|z| z.abs() <= largest), "{radial} {angular}: {pair:?}");
            }
        }
    }
}
