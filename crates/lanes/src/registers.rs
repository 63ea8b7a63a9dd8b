//! Registers of a level: load, store and compress.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::numbers::Lanes;
use crate::sealed::Sealed;

/// Largest number of lanes in a register of any level.
///
/// Pad slices by it where the last block may extend beyond them.
pub const MOST_LANES: usize = 16;

/// Registers of a level for numbers of type `T`, `f64` or `f32`; arithmetic and comparisons are in [`Lanes`].
///
/// Every function compiles to one instruction or a few. Only [`SimdLevel::run`](crate::SimdLevel::run) creates
/// registers, so they exist only on machines that support them.
///
/// Panics: slices shorter than the range read or written, as in indexing.
pub trait Registers<T>: Copy + Sealed {
    /// Number of lanes in a register, at most [`MOST_LANES`].
    const N: usize;
    /// Whether [`mask`](Self::mask) is free because the level stores masks as one bit for each lane.
    const MASKS_ARE_BITS: bool;
    /// A register.
    type Vector: Lanes<Number = T>;
    /// `N` numbers in memory.
    type Block;
    /// `N` indices in memory.
    type Indices;
    /// All complete blocks of a slice.
    fn blocks(values: &[T]) -> &[Self::Block];
    /// All complete blocks of indices in a slice.
    fn index_blocks(indices: &[u32]) -> &[Self::Indices];
    /// The block that starts at an index of a slice.
    fn block_at(values: &[T], at: usize) -> &Self::Block;
    /// The block of indices that starts at an index of a slice.
    fn indices_at(indices: &[u32], at: usize) -> &Self::Indices;
    /// Fills every lane with the same number.
    fn splat(self, value: T) -> Self::Vector;
    /// Loads a block into a register.
    fn load(self, values: &Self::Block) -> Self::Vector;
    /// Loads the numbers of a slice from an index on.
    #[inline(always)]
    fn load_at(self, values: &[T], at: usize) -> Self::Vector {
        self.load(Self::block_at(values, at))
    }
    /// Stores a register in a slice from an index on.
    fn store_at(self, vector: Self::Vector, values: &mut [T], at: usize);
    /// Converts the lowest `N` bits to a mask: lane `k` is bit `k`.
    fn mask(self, bits: u32) -> <Self::Vector as Lanes>::Mask;
    /// `a b + c`, rounded once or twice: **the only function whose result depends on the level**.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// Packs the lanes of a mask into `out[to..]`; the rest of `out[to..to + N]` is left undefined.
    fn compress(self, mask: u32, vector: Self::Vector, out: &mut [T], to: usize);
    /// Packs indices as [`compress`](Self::compress) does; returns their number.
    fn compress_indices(self, mask: u32, ids: &Self::Indices, out: &mut [u32], to: usize) -> usize;
    /// Runs work as a separate function at the same level.
    ///
    /// Use it for a rare branch of a loop, which would otherwise occupy registers of the frequent branch.
    fn apart<W: Work<T>>(self, work: W) -> W::Output;
}

/// Work that [`SimdLevel::run`](crate::SimdLevel::run) compiles once for each level.
///
/// Write it with [`Registers`] and [`Lanes`], or as a loop that the compiler vectorises and that ignores the
/// registers. Mark `run`, and the functions it calls, `#[inline(always)]`.
///
/// ```
/// use lanes::{Lanes, Mask, Registers, SimdLevel, Work};
///
/// /// How many numbers are below a limit.
/// struct CountBelow<'a>(&'a [f32], f32);
///
/// impl Work<f32> for CountBelow<'_> {
///     type Output = u32;
///
///     #[inline(always)]
///     fn run<R: Registers<f32>>(self, registers: R) -> u32 {
///         let limit = registers.splat(self.1);
///         let blocks = R::blocks(self.0).iter();
///         blocks.map(|block| registers.load(block).less(limit).bits().count_ones()).sum()
///     }
/// }
///
/// let values: Vec<f32> = (0..32_u8).map(f32::from).collect();
/// for level in SimdLevel::available() {
///     assert_eq!(level.run(CountBelow(&values, 10.0)), 10);
/// }
/// ```
pub trait Work<T> {
    /// Return type of the work.
    type Output;
    /// Runs the work on the registers of a level.
    fn run<R: Registers<T>>(self, registers: R) -> Self::Output;
}

/// A vector or mask together with the level whose instructions it uses.
#[derive(Debug, Clone, Copy)]
pub struct Packed<L, V>(pub(crate) L, pub(crate) V);

impl<L, V> Sealed for Packed<L, V> {}

/// The `N` entries of a slice from an index on, as an array.
#[inline(always)]
pub(crate) fn chunk<T, const N: usize>(slice: &[T], at: usize) -> &[T; N] {
    slice[at..at + N].first_chunk().expect("a slice of N")
}

/// The same as [`chunk`], mutable.
#[inline(always)]
pub(crate) fn chunk_mut<T, const N: usize>(slice: &mut [T], at: usize) -> &mut [T; N] {
    slice[at..at + N].first_chunk_mut().expect("a slice of N")
}

/// Stores every value; the next store overwrites it unless its bit is set. No branch can be mispredicted.
#[inline(always)]
pub(crate) fn to_front<T: Copy, const N: usize>(
    mask: u32,
    values: &[T; N],
    out: &mut [T; N],
) -> usize {
    let mut end = 0;
    for k in 0..N {
        out[end & (N - 1)] = values[k];
        end += (mask >> k & 1) as usize;
    }
    end
}

/// Splits slices into blocks of a given number of lanes.
macro_rules! blocks {
    ($real:ty, $n:expr) => {
        const N: usize = $n;
        type Block = [$real; $n];
        type Indices = [u32; $n];

        #[inline(always)]
        fn blocks(values: &[$real]) -> &[Self::Block] {
            values.as_chunks().0
        }
        #[inline(always)]
        fn index_blocks(indices: &[u32]) -> &[Self::Indices] {
            indices.as_chunks().0
        }
        #[inline(always)]
        fn block_at(values: &[$real], at: usize) -> &Self::Block {
            $crate::registers::chunk(values, at)
        }
        #[inline(always)]
        fn indices_at(indices: &[u32], at: usize) -> &Self::Indices {
            $crate::registers::chunk(indices, at)
        }
    };
}
pub(crate) use blocks;
