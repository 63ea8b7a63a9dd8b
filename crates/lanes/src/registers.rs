//! Registers of a level: how they are filled, stored and compressed.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::numbers::Lanes;
use crate::sealed::Sealed;

/// The most lanes that a register of any level has. Pad slices by it where a block at the end may reach beyond them.
pub const MOST_LANES: usize = 16;

/// Registers of a level for numbers of the type `T`, `f64` or `f32`; arithmetic and comparisons are those of [`Lanes`].
///
/// Every function compiles to an instruction or a few. Only [`SimdLevel::run`](crate::SimdLevel::run) hands registers
/// out, so that they exist only where the machine has them.
///
/// Panics: slices shorter than what is read or written, as indexing does.
pub trait Registers<T>: Copy + Sealed {
    /// Lanes of a register, at most [`MOST_LANES`].
    const N: usize;
    /// Whether [`mask`](Self::mask) costs nothing, since the level's masks are a bit for each lane.
    const MASKS_ARE_BITS: bool;
    /// A register.
    type Vector: Lanes<Number = T>;
    /// `N` numbers in memory.
    type Block;
    /// `N` indices in memory.
    type Indices;
    /// All whole blocks of a slice.
    fn blocks(values: &[T]) -> &[Self::Block];
    /// All whole blocks of indices of a slice.
    fn index_blocks(indices: &[u32]) -> &[Self::Indices];
    /// The block that starts at an index of a slice.
    fn block_at(values: &[T], at: usize) -> &Self::Block;
    /// The block of indices that starts at an index of a slice.
    fn indices_at(indices: &[u32], at: usize) -> &Self::Indices;
    /// The same number in every lane.
    fn splat(self, value: T) -> Self::Vector;
    /// A block as a register.
    fn load(self, values: &Self::Block) -> Self::Vector;
    /// The numbers of a slice from an index on.
    #[inline(always)]
    fn load_at(self, values: &[T], at: usize) -> Self::Vector {
        self.load(Self::block_at(values, at))
    }
    /// Writes a register to a slice from an index on.
    fn store_at(self, vector: Self::Vector, values: &mut [T], at: usize);
    /// The mask of the lowest `N` bits: lane `k` is bit `k`.
    fn mask(self, bits: u32) -> <Self::Vector as Lanes>::Mask;
    /// `a b + c`, rounded once or twice: **the one function whose bits depend on the level**.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// Writes the lanes of a mask one after the other to `out[to..]`; the rest of `out[to..to + N]` is left undefined.
    fn compress(self, mask: u32, vector: Self::Vector, out: &mut [T], to: usize);
    /// As [`compress`](Self::compress), of indices; returns how many they are.
    fn compress_indices(self, mask: u32, ids: &Self::Indices, out: &mut [u32], to: usize) -> usize;
    /// Runs work as a function of its own at the same level: a rare branch of a loop, which would otherwise take registers
    /// from the frequent one.
    fn apart<W: Work<T>>(self, work: W) -> W::Output;
}

/// Work that [`SimdLevel::run`](crate::SimdLevel::run) compiles once for each level.
///
/// Write it with [`Registers`] and [`Lanes`], or as a loop that the compiler vectorises and that leaves the registers
/// unused. Mark `run`, and what it calls, `#[inline(always)]`.
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
    /// What the work returns.
    type Output;
    /// The work, on the registers of a level.
    fn run<R: Registers<T>>(self, registers: R) -> Self::Output;
}

/// Values, or a mask, that the instructions of a level compute with.
#[derive(Debug, Clone, Copy)]
pub struct Packed<L, V>(pub(crate) L, pub(crate) V);

impl<L, V> Sealed for Packed<L, V> {}

/// The `N` entries of a slice from an index on.
#[inline(always)]
pub(crate) fn chunk<T, const N: usize>(slice: &[T], at: usize) -> &[T; N] {
    slice[at..at + N].first_chunk().expect("a slice of N")
}

/// As [`chunk`], to write.
#[inline(always)]
pub(crate) fn chunk_mut<T, const N: usize>(slice: &mut [T], at: usize) -> &mut [T; N] {
    slice[at..at + N].first_chunk_mut().expect("a slice of N")
}

/// Every value is written, and the next writes over it unless it was in the mask: no branch to mispredict.
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

/// Slices as blocks of so many lanes.
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
