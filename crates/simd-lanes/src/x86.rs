//! The registers of AVX2 and AVX-512.
//!
//! There is no `unsafe`: pulp creates its tokens only where the instructions exist.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use core::arch::x86_64::__m256i;
use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Sub};

use pulp::bytemuck::Pod;
use pulp::x86::{V3, V4};
use pulp::{
    NullaryFnOnce, Simd, b8, b16, cast, f32x8, f32x16, f64x4, f64x8, m32x8, m64x4, u64x4, u64x8,
};

use crate::elementary::{Binary64, ONE, SQRT_HALF, TWO_52, exp_of, exp_rounded, ln_of, ln_rounded};
use crate::numbers::{Lanes, Mask};
use crate::registers::{Packed, Registers, Work, blocks, chunk_mut, to_front};
use crate::sealed::Sealed;
use crate::x86_fours::Fours;

/// Work on the registers of a level, in the form that pulp accepts.
pub(crate) struct On<L, W, T> {
    level: L,
    work: W,
    number: PhantomData<T>,
}

impl<L, W, T> On<L, W, T> {
    #[inline(always)]
    pub(crate) fn new(level: L, work: W) -> Self {
        Self { level, work, number: PhantomData }
    }
}

impl<T, L: Registers<T>, W: Work<T>> NullaryFnOnce for On<L, W, T> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.work.run(self.level)
    }
}

/// For every mask of eight lanes, the permutation that packs the selected lanes to the front.
static FRONT: [[u32; 8]; 256] = front();

const fn front() -> [[u32; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut end) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][end] = lane;
                end += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
}

/// Packs the lanes of a mask at a level.
trait Front<B> {
    fn front(self, mask: u32, block: B, out: &mut B);
}

impl Front<[f32; 8]> for V3 {
    #[inline(always)]
    fn front(self, mask: u32, block: [f32; 8], out: &mut [f32; 8]) {
        let front: __m256i = cast(FRONT[(mask & 0xff) as usize]);
        *out = cast(self.avx2._mm256_permutevar8x32_ps(cast(block), front));
    }
}

impl Front<[u32; 8]> for V3 {
    #[inline(always)]
    fn front(self, mask: u32, block: [u32; 8], out: &mut [u32; 8]) {
        let front: __m256i = cast(FRONT[(mask & 0xff) as usize]);
        *out = cast(self.avx2._mm256_permutevar8x32_epi32(cast(block), front));
    }
}

impl<T: Copy> Front<[T; 4]> for V3 {
    #[inline(always)]
    fn front(self, mask: u32, block: [T; 4], out: &mut [T; 4]) {
        to_front(mask, &block, out);
    }
}

/// Compresses in a register and stores it whole: compressing into memory is slow on some machines.
macro_rules! front_by_instruction {
    ($block:ty, $mask:ty, $features:ident, $compress:ident) => {
        impl Front<$block> for V4 {
            #[inline(always)]
            #[expect(clippy::cast_possible_truncation, reason = "as many bits as lanes")]
            fn front(self, mask: u32, block: $block, out: &mut $block) {
                *out = cast(self.$features.$compress(mask as $mask, cast(block)));
            }
        }
    };
}
front_by_instruction!([f32; 16], u16, avx512f, _mm512_maskz_compress_ps);
front_by_instruction!([u32; 16], u16, avx512f, _mm512_maskz_compress_epi32);
front_by_instruction!([f64; 8], u8, avx512f, _mm512_maskz_compress_pd);
front_by_instruction!([u32; 8], u8, avx512f, _mm256_maskz_compress_epi32);

/// Stores masks of type `M` at a level.
trait Masks<M> {
    fn bits_of(self, mask: M) -> u32;
    fn of_bits(self, bits: u32) -> M;
}

/// Masks as one word for each lane, with all its bits set or none.
macro_rules! masks_of_words {
    ($mask:ident, $word:ty, $n:literal, $movemask:ident, $splat:ident, $and:ident, $equal:ident) => {
        impl Masks<$mask> for V3 {
            #[inline(always)]
            #[expect(clippy::cast_sign_loss, reason = "the bits of a movemask")]
            fn bits_of(self, mask: $mask) -> u32 {
                self.avx.$movemask(cast(mask)) as u32
            }
            #[inline(always)]
            fn of_bits(self, bits: u32) -> $mask {
                let of_lanes = cast(const { bit_of_each_lane::<$n>() }.map(<$word>::from));
                self.$equal(self.$and(self.$splat(bits.into()), of_lanes), of_lanes)
            }
        }
    };
}
masks_of_words!(m32x8, u32, 8, _mm256_movemask_ps, splat_u32s, and_u32s, equal_u32s);
masks_of_words!(m64x4, u64, 4, _mm256_movemask_pd, splat_u64s, and_u64s, equal_u64s);

const fn bit_of_each_lane<const N: usize>() -> [u32; N] {
    let mut bits = [1; N];
    let mut lane = 1;
    while lane < N {
        bits[lane] = 2 * bits[lane - 1];
        lane += 1;
    }
    bits
}

/// Masks as one bit for each lane.
macro_rules! masks_of_bits {
    ($mask:ident, $bits:ty) => {
        impl Masks<$mask> for V4 {
            #[inline(always)]
            fn bits_of(self, mask: $mask) -> u32 {
                mask.0.into()
            }
            #[inline(always)]
            #[expect(clippy::cast_possible_truncation, reason = "as many bits as lanes")]
            fn of_bits(self, bits: u32) -> $mask {
                $mask(bits as $bits)
            }
        }
    };
}
masks_of_bits!(b8, u8);
masks_of_bits!(b16, u16);

macro_rules! operator {
    ($level:ident, $vector:ident, $trait:ident, $function:ident, $of_pulp:ident) => {
        impl $trait for Packed<$level, $vector> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0, self.0.$of_pulp(self.1, other.1))
            }
        }
    };
}

/// Implements the registers of one number type at a level, through functions that pulp names alike at both levels.
macro_rules! registers {
    (($level:ident, $n:literal, $real:ident, $vector:ident, $mask:ident),
     ($add:ident, $sub:ident, $mul:ident, $div:ident, $mul_add:ident),
     ($splat:ident, $sqrt:ident, $abs:ident, $min:ident, $max:ident),
     ($less:ident, $at_least:ident, $select:ident),
     ($and:ident, $or:ident, $not:ident),
     ($exp:expr, $ln:expr)) => {
        operator!($level, $vector, Add, add, $add);
        operator!($level, $vector, Sub, sub, $sub);
        operator!($level, $vector, Mul, mul, $mul);
        operator!($level, $vector, Div, div, $div);

        impl Lanes for Packed<$level, $vector> {
            type Number = $real;
            type Mask = Packed<$level, $mask>;

            #[inline(always)]
            fn splat(self, value: $real) -> Self {
                Self(self.0, self.0.$splat(value))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0, self.0.$sqrt(self.1))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0, self.0.$abs(self.1))
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(self.0, self.0.$min(self.1, other.1))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(self.0, self.0.$max(self.1, other.1))
            }
            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                Packed(self.0, self.0.$less(self.1, other.1))
            }
            #[inline(always)]
            fn at_least(self, other: Self) -> Self::Mask {
                Packed(self.0, self.0.$at_least(self.1, other.1))
            }
            #[inline(always)]
            fn select(mask: Self::Mask, inside: Self, outside: Self) -> Self {
                Self(mask.0, mask.0.$select(mask.1, inside.1, outside.1))
            }
            #[inline(always)]
            fn lane(self, lane: u32) -> $real {
                let lanes: [$real; $n] = cast(self.1);
                lanes[(lane as usize).min($n - 1)]
            }
        }

        impl Mask for Packed<$level, $mask> {
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                Packed(self.0, self.0.$and(self.1, other.1))
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                Packed(self.0, self.0.$or(self.1, other.1))
            }
            #[inline(always)]
            fn not(self) -> Self {
                Packed(self.0, self.0.$not(self.1))
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self.0.bits_of(self.1)
            }
        }

        impl Registers<$real> for $level {
            blocks!($real, $n);
            const MASKS_ARE_BITS: bool = size_of::<$mask>() * 8 == $n;
            type Vector = Packed<Self, $vector>;

            #[inline(always)]
            fn splat(self, value: $real) -> Self::Vector {
                Packed(self, self.$splat(value))
            }
            #[inline(always)]
            fn load(self, values: &Self::Block) -> Self::Vector {
                Packed(self, cast(*values))
            }
            #[inline(always)]
            fn store_at(self, vector: Self::Vector, values: &mut [$real], at: usize) {
                *chunk_mut::<$real, $n>(values, at) = cast(vector.1);
            }
            #[inline(always)]
            fn mask(self, bits: u32) -> <Self::Vector as Lanes>::Mask {
                Packed(self, self.of_bits(bits))
            }
            #[inline(always)]
            fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
                Packed(self, self.$mul_add(a.1, b.1, c.1))
            }
            #[inline(always)]
            fn load_fours(self, fours: &[&[$real; 4]]) -> Self::Vector {
                Packed(self, self.loaded(fours))
            }
            #[inline(always)]
            fn spread_fours(self, fours: &[&[$real; 4]]) -> [Self::Vector; 4] {
                let [a, b, c, d] = self.spread(fours);
                [Packed(self, a), Packed(self, b), Packed(self, c), Packed(self, d)]
            }
            #[inline(always)]
            fn four(self, vector: Self::Vector, block: usize) -> [$real; 4] {
                self.block(vector.1, block)
            }
            #[inline(always)]
            fn add_four(self, vector: Self::Vector, block: usize, to: &mut [$real; 4]) {
                self.add_block(vector.1, block, to);
            }
            #[inline(always)]
            fn unzip_fours(self, low: Self::Vector, high: Self::Vector) -> [Self::Vector; 2] {
                let [first, second] = self.unzipped(low.1, high.1);
                [Packed(self, first), Packed(self, second)]
            }
            #[inline(always)]
            fn zip_fours(self, first: Self::Vector, second: Self::Vector) -> [Self::Vector; 2] {
                let [low, high] = self.zipped(first.1, second.1);
                [Packed(self, low), Packed(self, high)]
            }
            #[inline(always)]
            fn transpose_fours(self, [a, b, c, d]: [Self::Vector; 4]) -> [Self::Vector; 4] {
                let [a, b, c, d] = self.transposed([a.1, b.1, c.1, d.1]);
                [Packed(self, a), Packed(self, b), Packed(self, c), Packed(self, d)]
            }
            #[inline(always)]
            fn sum_fours(self, [a, b, c, d]: [Self::Vector; 4]) -> Self::Vector {
                Packed(self, self.sums([a.1, b.1, c.1, d.1]))
            }
            #[inline(always)]
            fn compress(self, mask: u32, vector: Self::Vector, out: &mut [$real], to: usize) {
                self.front(mask, cast(vector.1), chunk_mut::<$real, $n>(out, to));
            }
            #[inline(always)]
            fn compress_indices(
                self,
                mask: u32,
                ids: &Self::Indices,
                out: &mut [u32],
                to: usize,
            ) -> usize {
                self.front(mask, *ids, chunk_mut::<u32, $n>(out, to));
                mask.count_ones() as usize
            }
            #[inline(always)]
            fn apart<W: Work<$real>>(self, work: W) -> W::Output {
                self.vectorize(On::new(self, work))
            }
        }
    };
}

macro_rules! f32_registers {
    ($level:ident, $n:literal, $vector:ident, $mask:ident) => {
        registers!(
            ($level, $n, f32, $vector, $mask),
            (add_f32s, sub_f32s, mul_f32s, div_f32s, mul_add_f32s),
            (splat_f32s, sqrt_f32s, abs_f32s, min_f32s, max_f32s),
            (less_than_f32s, greater_than_or_equal_f32s, select_f32s),
            (and_m32s, or_m32s, not_m32s),
            (|x| each_of::<_, _, $n>(x, exp_rounded), |x| each_of::<_, _, $n>(x, ln_rounded))
        );
    };
}
f32_registers!(V3, 8, f32x8, m32x8);
f32_registers!(V4, 16, f32x16, b16);

macro_rules! f64_registers {
    ($level:ident, $n:literal, $vector:ident, $mask:ident) => {
        registers!(
            ($level, $n, f64, $vector, $mask),
            (add_f64s, sub_f64s, mul_f64s, div_f64s, mul_add_f64s),
            (splat_f64s, sqrt_f64s, abs_f64s, min_f64s, max_f64s),
            (less_than_f64s, greater_than_or_equal_f64s, select_f64s),
            (and_m64s, or_m64s, not_m64s),
            (exp_of, ln_of)
        );
    };
}
f64_registers!(V3, 4, f64x4, m64x4);
f64_registers!(V4, 8, f64x8, b8);

/// A function of each lane, lane by lane.
#[inline(always)]
fn each_of<L, V: Pod, const N: usize>(x: Packed<L, V>, f: impl Fn(f32) -> f32) -> Packed<L, V>
where
    [f32; N]: Pod,
{
    let mut lanes: [f32; N] = cast(x.1);
    for lane in &mut lanes {
        *lane = f(*lane);
    }
    Packed(x.0, cast(lanes))
}

/// Implements [`Binary64`] of a register, by the operations of [`binade`](crate::elementary::binade) and
/// [`power_of_two`](crate::elementary::power_of_two).
macro_rules! binary64 {
    ($level:ident, $vector:ident, $words:ident, $features:ident, $shift_left:ident, $shift_right:ident) => {
        impl Binary64 for Packed<$level, $vector> {
            #[inline(always)]
            fn binade(self) -> (Self, Self) {
                let Self(level, x) = self;
                let shifted = level.add_u64s(cast(x), level.splat_u64s(ONE - SQRT_HALF));
                let exponent: $words =
                    cast(level.$features.$shift_right::<52>(cast::<$words, _>(shifted)));
                let k = level.or_u64s(exponent, level.splat_u64s(TWO_52.to_bits()));
                let mantissa = level.and_u64s(shifted, level.splat_u64s(u64::MAX >> 12));
                let f = level.add_u64s(mantissa, level.splat_u64s(SQRT_HALF));
                let (k, f) = (Self(level, cast(k)), Self(level, cast(f)));
                (k - self.splat(TWO_52 + 1023.0), f - self.splat(1.0))
            }

            #[inline(always)]
            fn power_of_two(self) -> Self {
                let Self(level, rounded) = self;
                let k: $words =
                    cast(level.$features.$shift_left::<52>(cast::<$vector, _>(rounded)));
                Self(level, cast(level.add_u64s(k, level.splat_u64s(ONE))))
            }
        }
    };
}
binary64!(V3, f64x4, u64x4, avx2, _mm256_slli_epi64, _mm256_srli_epi64);
binary64!(V4, f64x8, u64x8, avx512f, _mm512_slli_epi64, _mm512_srli_epi64);

impl Sealed for V3 {}
impl Sealed for V4 {}
