//! The registers of AVX2 and AVX-512.
//!
//! There is no `unsafe`: pulp hands out its tokens only where the instructions exist.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use core::arch::x86_64::{__m256, __m256i, __m512, _CMP_LT_OQ};

use pulp::cast;
use pulp::x86::{V3, V4};

use crate::registers::{Registers, blocks, chunk_mut, private};

/// For every mask of eight, which lanes go to the front.
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

#[inline(always)]
#[expect(clippy::cast_sign_loss, reason = "the bits of a movemask")]
fn bits(mask: i32) -> u32 {
    mask as u32
}

impl private::Sealed for V3 {}

impl Registers<f32> for V3 {
    blocks!(8);
    type Vector = __m256;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        cast([value; 8])
    }
    #[inline(always)]
    fn load(self, values: &Self::Block) -> Self::Vector {
        cast(*values)
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_add_ps(a, b)
    }
    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_sub_ps(a, b)
    }
    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_mul_ps(a, b)
    }
    #[inline(always)]
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.fma._mm256_fmadd_ps(a, b, c)
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_max_ps(a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        bits(self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b)))
    }
    #[inline(always)]
    fn compress_indices(self, mask: u32, ids: &Self::Indices, out: &mut [u32], to: usize) -> usize {
        let front: __m256i = cast(FRONT[(mask & 0xff) as usize]);
        let ids = cast(*ids);
        *chunk_mut::<u32, 8>(out, to) = cast(self.avx2._mm256_permutevar8x32_epi32(ids, front));
        mask.count_ones() as usize
    }
    #[inline(always)]
    fn compress(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize) {
        let front: __m256i = cast(FRONT[(mask & 0xff) as usize]);
        *chunk_mut::<f32, 8>(out, to) = cast(self.avx2._mm256_permutevar8x32_ps(vector, front));
    }
}

impl private::Sealed for V4 {}

impl Registers<f32> for V4 {
    blocks!(16);
    type Vector = __m512;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        cast([value; 16])
    }
    #[inline(always)]
    fn load(self, values: &Self::Block) -> Self::Vector {
        cast(*values)
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_add_ps(a, b)
    }
    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_sub_ps(a, b)
    }
    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_mul_ps(a, b)
    }
    #[inline(always)]
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_fmadd_ps(a, b, c)
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_max_ps(a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        self.avx512f._mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b).into()
    }
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "sixteen lanes, sixteen bits")]
    fn compress_indices(self, mask: u32, ids: &Self::Indices, out: &mut [u32], to: usize) -> usize {
        let ids = cast(*ids);
        // To a register and out whole: compressing into memory is slow on some machines.
        *chunk_mut::<u32, 16>(out, to) =
            cast(self.avx512f._mm512_maskz_compress_epi32(mask as u16, ids));
        mask.count_ones() as usize
    }
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "sixteen lanes, sixteen bits")]
    fn compress(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize) {
        *chunk_mut::<f32, 16>(out, to) =
            cast(self.avx512f._mm512_maskz_compress_ps(mask as u16, vector));
    }
}
