//! Registers where the compiler chooses them: loops over arrays of eight.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::registers::{Registers, blocks, chunk_mut, private};

/// Instructions that every machine has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable {
    /// Every x86-64 has it, and it makes a mask of four comparisons at once.
    #[cfg(target_arch = "x86_64")]
    sse: pulp::core_arch::x86::Sse,
}

impl Portable {
    #[inline]
    pub(crate) fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            sse: pulp::core_arch::x86::Sse::try_new().expect("every x86-64 has SSE"),
        }
    }
}

/// Lanes.
const N: usize = 8;

#[inline(always)]
fn each(value: impl Fn(usize) -> f32) -> [f32; N] {
    core::array::from_fn(value)
}

/// Every value is written, and the next writes over it unless it was in the mask: no branch to mispredict.
#[inline(always)]
fn to_front<T: Copy>(mask: u32, values: &[T; N], out: &mut [T; N]) -> usize {
    let mut end = 0;
    for k in 0..N {
        out[end & (N - 1)] = values[k];
        end += (mask >> k & 1) as usize;
    }
    end
}

impl private::Sealed for Portable {}

impl Registers<f32> for Portable {
    blocks!(8);
    type Vector = [f32; N];

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        [value; N]
    }
    #[inline(always)]
    fn load(self, values: &Self::Block) -> Self::Vector {
        *values
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| a[k] * b[k])
    }
    #[inline(always)]
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        each(|k| a[k] * b[k] + c[k])
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    #[expect(clippy::cast_sign_loss, reason = "the bits of a movemask")]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        let (a, b): ([_; 2], [_; 2]) = (pulp::cast(a), pulp::cast(b));
        let half = |k: usize| self.sse._mm_movemask_ps(self.sse._mm_cmplt_ps(a[k], b[k])) as u32;
        half(0) | half(1) << 4
    }
    #[inline(always)]
    #[cfg(not(target_arch = "x86_64"))]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        (0..N).fold(0, |mask, k| mask | u32::from(a[k] < b[k]) << k)
    }
    #[inline(always)]
    fn compress_indices(self, mask: u32, ids: &Self::Indices, out: &mut [u32], to: usize) -> usize {
        to_front(mask, ids, chunk_mut(out, to))
    }
    #[inline(always)]
    fn compress(self, mask: u32, vector: Self::Vector, out: &mut [f32], to: usize) {
        to_front(mask, &vector, chunk_mut(out, to));
    }
}
