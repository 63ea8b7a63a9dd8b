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
    /// Loads blocks of four lanes from several places: block `b` from `fours[b]`.
    fn load_fours(self, fours: &[&[T; 4]]) -> Self::Vector;
    /// Fills every block of four lanes with one number: block `b` of register `k` with `fours[b][k]`.
    fn spread_fours(self, fours: &[&[T; 4]]) -> [Self::Vector; 4];
    /// One block of four lanes.
    fn four(self, vector: Self::Vector, block: usize) -> [T; 4];
    /// Adds one block of four lanes to numbers in memory.
    fn add_four(self, vector: Self::Vector, block: usize, to: &mut [T; 4]);
    /// Separates pairs, of which every block of four lanes holds two: the first numbers of the pairs of `low` and `high`, and the
    /// second.
    fn unzip_fours(self, low: Self::Vector, high: Self::Vector) -> [Self::Vector; 2];
    /// Brings together what [`unzip_fours`](Self::unzip_fours) separates.
    fn zip_fours(self, first: Self::Vector, second: Self::Vector) -> [Self::Vector; 2];
    /// Transposes every block of four lanes: lane `k` of a block of row `i` becomes lane `i` of this block of row `k`.
    fn transpose_fours(self, rows: [Self::Vector; 4]) -> [Self::Vector; 4];
    /// Sums every block of four lanes: lane `k` of a block is the sum `(x_0 + x_1) + (x_2 + x_3)` of this block of row `k`.
    fn sum_fours(self, rows: [Self::Vector; 4]) -> Self::Vector;
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
/// use simd_lanes::{Lanes, Mask, Registers, SimdLevel, Work};
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

/// Transposes blocks of four entries of four rows.
#[inline(always)]
pub(crate) fn transposed<T: Copy, const N: usize>(rows: [[T; N]; 4]) -> [[T; N]; 4] {
    let mut columns = rows;
    for at in 0..N {
        let (block, k) = (at / 4 * 4, at % 4);
        for i in 0..4 {
            columns[k][block + i] = rows[i][at];
        }
    }
    columns
}

/// Loads blocks of four entries.
#[inline(always)]
pub(crate) fn loaded<T: Copy + Default, const N: usize>(fours: &[&[T; 4]]) -> [T; N] {
    let mut lanes = [T::default(); N];
    for at in 0..N {
        lanes[at] = fours[at / 4][at % 4];
    }
    lanes
}

/// Fills blocks of four entries with one number each.
#[inline(always)]
pub(crate) fn spread<T: Copy + Default, const N: usize>(fours: &[&[T; 4]]) -> [[T; N]; 4] {
    let mut rows = [[T::default(); N]; 4];
    for at in 0..N {
        for k in 0..4 {
            rows[k][at] = fours[at / 4][k];
        }
    }
    rows
}

/// One block of four entries.
#[inline(always)]
pub(crate) fn four<T: Copy, const N: usize>(lanes: &[T; N], block: usize) -> [T; 4] {
    *chunk(lanes, 4 * block)
}

/// Adds one block of four entries to others.
#[inline(always)]
pub(crate) fn add<T: Lanes, const N: usize>(lanes: &[T; N], block: usize, to: &mut [T; 4]) {
    for k in 0..4 {
        to[k] = to[k] + lanes[4 * block + k];
    }
}

/// Separates pairs in blocks of four entries.
#[inline(always)]
pub(crate) fn unzipped<T: Copy, const N: usize>(low: [T; N], high: [T; N]) -> [[T; N]; 2] {
    let mut halves = [low, high];
    for at in 0..N {
        let (block, k) = (at / 4 * 4, at % 4);
        let pairs = if k < 2 { &low } else { &high };
        for half in 0..2 {
            halves[half][at] = pairs[block + 2 * (k % 2) + half];
        }
    }
    halves
}

/// Brings together the numbers of pairs in blocks of four entries.
#[inline(always)]
pub(crate) fn zipped<T: Copy, const N: usize>(first: [T; N], second: [T; N]) -> [[T; N]; 2] {
    let mut halves = [first, second];
    for at in 0..N {
        let (block, k) = (at / 4 * 4, at % 4);
        let of = if k % 2 == 0 { &first } else { &second };
        for half in 0..2 {
            halves[half][at] = of[block + 2 * half + k / 2];
        }
    }
    halves
}

/// Sums blocks of four entries of four rows; the order of the sums is that of every level.
#[inline(always)]
pub(crate) fn sums<T: Lanes, const N: usize>(rows: [[T; N]; 4]) -> [T; N] {
    let mut sums = rows[0];
    for at in 0..N {
        let block = at / 4 * 4;
        let row = &rows[at % 4];
        sums[at] = (row[block] + row[block + 1]) + (row[block + 2] + row[block + 3]);
    }
    sums
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
