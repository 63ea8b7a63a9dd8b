//! The portable level: loops over arrays of 32 bytes, for which the compiler chooses the registers.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use crate::numbers::{Lanes, Mask};
use crate::registers::{
    Packed, Registers, Work, add, blocks, chunk_mut, four, loaded, spread, sums, to_front,
    transposed, unzipped, zipped,
};
use crate::sealed::Sealed;

/// The portable level: instructions that every machine supports.
#[derive(Debug, Clone, Copy)]
pub struct Portable {
    /// Tokens of SSE and SSE2, which every x86-64 supports; they combine several comparisons into one mask.
    #[cfg(target_arch = "x86_64")]
    sse: pulp::core_arch::x86::Sse,
    #[cfg(target_arch = "x86_64")]
    sse2: pulp::core_arch::x86::Sse2,
}

impl Portable {
    #[inline]
    pub(crate) fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            sse: pulp::core_arch::x86::Sse::try_new().expect("every x86-64 has SSE"),
            #[cfg(target_arch = "x86_64")]
            sse2: pulp::core_arch::x86::Sse2::try_new().expect("every x86-64 has SSE2"),
        }
    }
}

impl Sealed for Portable {}

/// Implements the operators on arrays of numbers.
macro_rules! operator {
    ($trait:ident, $function:ident, $operator:tt) => {
        impl<T: Lanes, const N: usize> $trait for Packed<Portable, [T; N]> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                self.each(|k| self.1[k] $operator other.1[k])
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<V, const N: usize> Packed<Portable, [V; N]> {
    #[inline(always)]
    fn each<W>(self, value: impl Fn(usize) -> W) -> Packed<Portable, [W; N]> {
        Packed(self.0, from_fn(value))
    }
}

/// Implements arrays of `$n` numbers of one type.
///
/// Their masks are words of the same size, with all bits of a word set or none.
macro_rules! portable {
    ($real:ty, $n:literal, $word:ty, $bits:item) => {
        impl Lanes for Packed<Portable, [$real; $n]> {
            type Number = $real;
            type Mask = Packed<Portable, [$word; $n]>;

            #[inline(always)]
            fn splat(self, value: $real) -> Self {
                Self(self.0, [value; $n])
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.each(|k| self.1[k].sqrt())
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.each(|k| self.1[k].abs())
            }
            #[inline(always)]
            fn exp(self) -> Self {
                self.each(|k| Lanes::exp(self.1[k]))
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.each(|k| Lanes::ln(self.1[k]))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.each(|k| Lanes::min(self.1[k], other.1[k]))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.each(|k| Lanes::max(self.1[k], other.1[k]))
            }
            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                self.each(|k| if self.1[k] < other.1[k] { <$word>::MAX } else { 0 })
            }
            #[inline(always)]
            fn at_least(self, other: Self) -> Self::Mask {
                self.each(|k| if self.1[k] >= other.1[k] { <$word>::MAX } else { 0 })
            }
            #[inline(always)]
            fn select(mask: Self::Mask, inside: Self, outside: Self) -> Self {
                inside.each(|k| if mask.1[k] != 0 { inside.1[k] } else { outside.1[k] })
            }
            #[inline(always)]
            fn lane(self, lane: u32) -> $real {
                self.1[(lane as usize).min($n - 1)]
            }
        }

        impl Mask for Packed<Portable, [$word; $n]> {
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                self.each(|k| self.1[k] & other.1[k])
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                self.each(|k| self.1[k] | other.1[k])
            }
            #[inline(always)]
            fn not(self) -> Self {
                self.each(|k| !self.1[k])
            }
            #[inline(always)]
            #[cfg(target_arch = "x86_64")]
            #[expect(clippy::cast_sign_loss, reason = "the bits of a movemask")]
            $bits
            #[inline(always)]
            #[cfg(not(target_arch = "x86_64"))]
            fn bits(self) -> u32 {
                (0..$n).fold(0, |bits, k| bits | u32::from(self.1[k] != 0) << k)
            }
        }

        impl Registers<$real> for Portable {
            blocks!($real, $n);
            const MASKS_ARE_BITS: bool = false;
            type Vector = Packed<Self, [$real; $n]>;

            #[inline(always)]
            fn splat(self, value: $real) -> Self::Vector {
                Packed(self, [value; $n])
            }
            #[inline(always)]
            fn load(self, values: &Self::Block) -> Self::Vector {
                Packed(self, *values)
            }
            #[inline(always)]
            fn store_at(self, vector: Self::Vector, values: &mut [$real], at: usize) {
                *chunk_mut(values, at) = vector.1;
            }
            #[inline(always)]
            fn mask(self, bits: u32) -> <Self::Vector as Lanes>::Mask {
                Packed(self, from_fn(|k| if bits >> k & 1 != 0 { <$word>::MAX } else { 0 }))
            }
            #[inline(always)]
            fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
                a * b + c
            }
            #[inline(always)]
            fn load_fours(self, fours: &[&[$real; 4]]) -> Self::Vector {
                Packed(self, loaded(fours))
            }
            #[inline(always)]
            fn spread_fours(self, fours: &[&[$real; 4]]) -> [Self::Vector; 4] {
                let [a, b, c, d] = spread(fours);
                [Packed(self, a), Packed(self, b), Packed(self, c), Packed(self, d)]
            }
            #[inline(always)]
            fn four(self, vector: Self::Vector, block: usize) -> [$real; 4] {
                four(&vector.1, block)
            }
            #[inline(always)]
            fn add_four(self, vector: Self::Vector, block: usize, to: &mut [$real; 4]) {
                add(&vector.1, block, to);
            }
            #[inline(always)]
            fn unzip_fours(self, low: Self::Vector, high: Self::Vector) -> [Self::Vector; 2] {
                let [first, second] = unzipped(low.1, high.1);
                [Packed(self, first), Packed(self, second)]
            }
            #[inline(always)]
            fn zip_fours(self, first: Self::Vector, second: Self::Vector) -> [Self::Vector; 2] {
                let [low, high] = zipped(first.1, second.1);
                [Packed(self, low), Packed(self, high)]
            }
            #[inline(always)]
            fn transpose_fours(self, [a, b, c, d]: [Self::Vector; 4]) -> [Self::Vector; 4] {
                let [a, b, c, d] = transposed([a.1, b.1, c.1, d.1]);
                [Packed(self, a), Packed(self, b), Packed(self, c), Packed(self, d)]
            }
            #[inline(always)]
            fn sum_fours(self, [a, b, c, d]: [Self::Vector; 4]) -> Self::Vector {
                Packed(self, sums([a.1, b.1, c.1, d.1]))
            }
            #[inline(always)]
            fn compress(self, mask: u32, vector: Self::Vector, out: &mut [$real], to: usize) {
                to_front::<_, $n>(mask, &vector.1, chunk_mut(out, to));
            }
            #[inline(always)]
            fn compress_indices(
                self,
                mask: u32,
                ids: &Self::Indices,
                out: &mut [u32],
                to: usize,
            ) -> usize {
                to_front::<_, $n>(mask, ids, chunk_mut(out, to))
            }
            #[inline(never)]
            fn apart<W: Work<$real>>(self, work: W) -> W::Output {
                work.run(self)
            }
        }
    };
}

portable!(
    f32,
    8,
    u32,
    fn bits(self) -> u32 {
        let halves: [_; 2] = pulp::cast(self.1);
        let half = |k: usize| self.0.sse._mm_movemask_ps(halves[k]) as u32;
        half(0) | half(1) << 4
    }
);
portable!(
    f64,
    4,
    u64,
    fn bits(self) -> u32 {
        let halves: [_; 2] = pulp::cast(self.1);
        let half = |k: usize| self.0.sse2._mm_movemask_pd(halves[k]) as u32;
        half(0) | half(1) << 2
    }
);
