//! Blocks of four lanes of AVX2 and AVX-512 registers.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::x86::{V3, V4};
use pulp::{Simd, cast, f32x8, f32x16, f64x4, f64x8};

use crate::registers::{add, four, loaded, spread, sums, transposed, unzipped, zipped};

/// Blocks of four lanes of registers `V`, of numbers `T`, at a level.
pub(crate) trait Fours<T, V>: Copy {
    fn loaded(self, fours: &[&[T; 4]]) -> V;
    fn spread(self, fours: &[&[T; 4]]) -> [V; 4];
    fn block(self, vector: V, block: usize) -> [T; 4];
    fn add_block(self, vector: V, block: usize, to: &mut [T; 4]);
    fn unzipped(self, low: V, high: V) -> [V; 2];
    fn zipped(self, first: V, second: V) -> [V; 2];
    fn transposed(self, rows: [V; 4]) -> [V; 4];
    fn sums(self, rows: [V; 4]) -> V;
}

/// Lanes of two rows by the instructions of a level.
trait Rows<V> {
    /// `[a_0 b_0 a_2 b_2]` and `[a_1 b_1 a_3 b_3]` of every block.
    fn alternate(self, a: V, b: V) -> [V; 2];
    /// `[a_0 a_1 b_0 b_1]` and `[a_2 a_3 b_2 b_3]` of every block.
    fn halves(self, a: V, b: V) -> [V; 2];
    fn add(self, a: V, b: V) -> V;
}

#[inline(always)]
fn transposed_rows<V: Copy, L: Rows<V> + Copy>(level: L, [a, b, c, d]: [V; 4]) -> [V; 4] {
    let ([even_ab, odd_ab], [even_cd, odd_cd]) = (level.alternate(a, b), level.alternate(c, d));
    let ([row_0, row_2], [row_1, row_3]) =
        (level.halves(even_ab, even_cd), level.halves(odd_ab, odd_cd));
    [row_0, row_1, row_2, row_3]
}

#[inline(always)]
fn sums_of_rows<V: Copy, L: Rows<V> + Copy>(level: L, [a, b, c, d]: [V; 4]) -> V {
    let ([even_ab, odd_ab], [even_cd, odd_cd]) = (level.alternate(a, b), level.alternate(c, d));
    let [low, high] = level.halves(level.add(even_ab, odd_ab), level.add(even_cd, odd_cd));
    level.add(low, high)
}

impl Rows<f64x4> for V3 {
    #[inline(always)]
    fn alternate(self, a: f64x4, b: f64x4) -> [f64x4; 2] {
        let even = self.avx._mm256_unpacklo_pd(cast(a), cast(b));
        let odd = self.avx._mm256_unpackhi_pd(cast(a), cast(b));
        [cast(even), cast(odd)]
    }
    #[inline(always)]
    fn halves(self, a: f64x4, b: f64x4) -> [f64x4; 2] {
        let low = self.avx._mm256_permute2f128_pd::<0x20>(cast(a), cast(b));
        let high = self.avx._mm256_permute2f128_pd::<0x31>(cast(a), cast(b));
        [cast(low), cast(high)]
    }
    #[inline(always)]
    fn add(self, a: f64x4, b: f64x4) -> f64x4 {
        self.add_f64s(a, b)
    }
}

impl Fours<f64, f64x4> for V3 {
    #[inline(always)]
    fn loaded(self, fours: &[&[f64; 4]]) -> f64x4 {
        cast(*fours[0])
    }
    /// Loads that fill a register take no shuffle.
    #[inline(always)]
    fn spread(self, fours: &[&[f64; 4]]) -> [f64x4; 4] {
        let &[a, b, c, d] = fours[0];
        [self.splat_f64s(a), self.splat_f64s(b), self.splat_f64s(c), self.splat_f64s(d)]
    }
    #[inline(always)]
    fn block(self, vector: f64x4, block: usize) -> [f64; 4] {
        four::<f64, 4>(&cast(vector), block)
    }
    #[inline(always)]
    fn add_block(self, vector: f64x4, block: usize, to: &mut [f64; 4]) {
        debug_assert!(block == 0);
        *to = cast(self.add_f64s(cast(*to), vector));
    }
    #[inline(always)]
    fn unzipped(self, low: f64x4, high: f64x4) -> [f64x4; 2] {
        let [first, second] = self.alternate(low, high);
        let first = self.avx2._mm256_permute4x64_pd::<0b11_01_10_00>(cast(first));
        let second = self.avx2._mm256_permute4x64_pd::<0b11_01_10_00>(cast(second));
        [cast(first), cast(second)]
    }
    #[inline(always)]
    fn zipped(self, first: f64x4, second: f64x4) -> [f64x4; 2] {
        let [even, odd] = self.alternate(first, second);
        self.halves(even, odd)
    }
    #[inline(always)]
    fn transposed(self, rows: [f64x4; 4]) -> [f64x4; 4] {
        transposed_rows(self, rows)
    }
    #[inline(always)]
    fn sums(self, rows: [f64x4; 4]) -> f64x4 {
        sums_of_rows(self, rows)
    }
}

/// Lanes of two registers: 0 to 7 of the first, 8 to 15 of the second.
#[inline(always)]
fn chosen(level: V4, a: f64x8, lanes: [u64; 8], b: f64x8) -> f64x8 {
    cast(level.avx512f._mm512_permutex2var_pd(cast(a), cast(lanes), cast(b)))
}

impl Rows<f64x8> for V4 {
    #[inline(always)]
    fn alternate(self, a: f64x8, b: f64x8) -> [f64x8; 2] {
        let even = self.avx512f._mm512_unpacklo_pd(cast(a), cast(b));
        let odd = self.avx512f._mm512_unpackhi_pd(cast(a), cast(b));
        [cast(even), cast(odd)]
    }
    #[inline(always)]
    fn halves(self, a: f64x8, b: f64x8) -> [f64x8; 2] {
        const LOW: [u64; 8] = [0, 1, 8, 9, 4, 5, 12, 13];
        const HIGH: [u64; 8] = [2, 3, 10, 11, 6, 7, 14, 15];
        [chosen(self, a, LOW, b), chosen(self, a, HIGH, b)]
    }
    #[inline(always)]
    fn add(self, a: f64x8, b: f64x8) -> f64x8 {
        self.add_f64s(a, b)
    }
}

impl Fours<f64, f64x8> for V4 {
    #[inline(always)]
    fn loaded(self, fours: &[&[f64; 4]]) -> f64x8 {
        let low = self.avx512f._mm512_castpd256_pd512(cast(*fours[0]));
        cast(self.avx512f._mm512_insertf64x4::<1>(low, cast(*fours[1])))
    }
    #[inline(always)]
    fn spread(self, fours: &[&[f64; 4]]) -> [f64x8; 4] {
        let all = cast(self.loaded(fours));
        [
            cast(self.avx512f._mm512_permutex_pd::<0b00_00_00_00>(all)),
            cast(self.avx512f._mm512_permutex_pd::<0b01_01_01_01>(all)),
            cast(self.avx512f._mm512_permutex_pd::<0b10_10_10_10>(all)),
            cast(self.avx512f._mm512_permutex_pd::<0b11_11_11_11>(all)),
        ]
    }
    #[inline(always)]
    fn block(self, vector: f64x8, block: usize) -> [f64; 4] {
        if block == 0 {
            cast(self.avx512f._mm512_extractf64x4_pd::<0>(cast(vector)))
        } else {
            cast(self.avx512f._mm512_extractf64x4_pd::<1>(cast(vector)))
        }
    }
    #[inline(always)]
    fn add_block(self, vector: f64x8, block: usize, to: &mut [f64; 4]) {
        let narrow: V3 = *self;
        let four = cast(Fours::block(self, vector, block));
        *to = cast(narrow.add_f64s(cast(*to), four));
    }
    #[inline(always)]
    fn unzipped(self, low: f64x8, high: f64x8) -> [f64x8; 2] {
        const FIRST: [u64; 8] = [0, 2, 8, 10, 4, 6, 12, 14];
        const SECOND: [u64; 8] = [1, 3, 9, 11, 5, 7, 13, 15];
        [chosen(self, low, FIRST, high), chosen(self, low, SECOND, high)]
    }
    #[inline(always)]
    fn zipped(self, first: f64x8, second: f64x8) -> [f64x8; 2] {
        const LOW: [u64; 8] = [0, 8, 1, 9, 4, 12, 5, 13];
        const HIGH: [u64; 8] = [2, 10, 3, 11, 6, 14, 7, 15];
        [chosen(self, first, LOW, second), chosen(self, first, HIGH, second)]
    }
    #[inline(always)]
    fn transposed(self, rows: [f64x8; 4]) -> [f64x8; 4] {
        transposed_rows(self, rows)
    }
    #[inline(always)]
    fn sums(self, rows: [f64x8; 4]) -> f64x8 {
        sums_of_rows(self, rows)
    }
}

/// Blocks of four `f32`, through memory: no inner loop needs them yet.
macro_rules! through_memory {
    ($level:ident, $vector:ident, $n:literal) => {
        impl Fours<f32, $vector> for $level {
            #[inline(always)]
            fn loaded(self, fours: &[&[f32; 4]]) -> $vector {
                cast(loaded::<f32, $n>(fours))
            }
            #[inline(always)]
            fn spread(self, fours: &[&[f32; 4]]) -> [$vector; 4] {
                let [a, b, c, d] = spread::<f32, $n>(fours);
                [cast(a), cast(b), cast(c), cast(d)]
            }
            #[inline(always)]
            fn block(self, vector: $vector, block: usize) -> [f32; 4] {
                four::<f32, $n>(&cast(vector), block)
            }
            #[inline(always)]
            fn add_block(self, vector: $vector, block: usize, to: &mut [f32; 4]) {
                add::<f32, $n>(&cast(vector), block, to);
            }
            #[inline(always)]
            fn unzipped(self, low: $vector, high: $vector) -> [$vector; 2] {
                let [first, second] = unzipped::<f32, $n>(cast(low), cast(high));
                [cast(first), cast(second)]
            }
            #[inline(always)]
            fn zipped(self, first: $vector, second: $vector) -> [$vector; 2] {
                let [low, high] = zipped::<f32, $n>(cast(first), cast(second));
                [cast(low), cast(high)]
            }
            #[inline(always)]
            fn transposed(self, [a, b, c, d]: [$vector; 4]) -> [$vector; 4] {
                let [a, b, c, d] = transposed::<f32, $n>([cast(a), cast(b), cast(c), cast(d)]);
                [cast(a), cast(b), cast(c), cast(d)]
            }
            #[inline(always)]
            fn sums(self, [a, b, c, d]: [$vector; 4]) -> $vector {
                cast(sums::<f32, $n>([cast(a), cast(b), cast(c), cast(d)]))
            }
        }
    };
}
through_memory!(V3, f32x8, 8);
through_memory!(V4, f32x16, 16);
