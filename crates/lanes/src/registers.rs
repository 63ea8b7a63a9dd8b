//! Registers of a level: vectors of numbers, and masks with a bit for each lane.

/// The most lanes that a register of any level has. Pad slices by it where a block at the end may reach beyond them.
pub const MOST_LANES: usize = 16;

/// Registers of a level for numbers of the type `T`, with masks: bit `k` is lane `k`.
///
/// Every function compiles to an instruction or a few. Only [`SimdLevel::run`](crate::SimdLevel::run) hands registers
/// out, so that they exist only where the machine has them. Here for `T = f32`.
///
/// Panics: slices shorter than what is read or written, as indexing does.
pub trait Registers<T>: Copy + private::Sealed {
    /// Lanes of a register, at most [`MOST_LANES`].
    const N: usize;
    /// A register.
    type Vector: Copy;
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
    /// `a + b`.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a - b`.
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b`.
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b + c`, rounded once or twice: **the one function whose bits depend on the level**.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// The larger of two finite numbers.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The mask of `a < b`.
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Writes the lanes of a mask one after the other to `out[to..]`; the rest of `out[to..to + N]` is left undefined.
    fn compress(self, mask: u32, vector: Self::Vector, out: &mut [T], to: usize);
    /// As [`compress`](Self::compress), of indices; returns how many they are.
    fn compress_indices(self, mask: u32, ids: &Self::Indices, out: &mut [u32], to: usize) -> usize;
}

/// Work that [`SimdLevel::run`](crate::SimdLevel::run) compiles once for each level.
///
/// Write it with the functions of [`Registers`], or as a loop that the compiler vectorises and that leaves the registers
/// unused. Mark `run`, and what it calls, `#[inline(always)]`.
///
/// ```
/// use lanes::{Registers, SimdLevel, Work};
///
/// /// How many numbers are below a limit.
/// struct CountBelow<'a>(&'a [f32], f32);
///
/// impl Work for CountBelow<'_> {
///     type Output = u32;
///
///     #[inline(always)]
///     fn run<R: Registers<f32>>(self, registers: R) -> u32 {
///         let limit = registers.splat(self.1);
///         let blocks = R::blocks(self.0).iter();
///         blocks.map(|block| registers.less(registers.load(block), limit).count_ones()).sum()
///     }
/// }
///
/// let values: Vec<f32> = (0..32_u8).map(f32::from).collect();
/// for level in SimdLevel::available() {
///     assert_eq!(level.run(CountBelow(&values, 10.0)), 10);
/// }
/// ```
pub trait Work {
    /// What the work returns.
    type Output;
    /// The work, on the registers of a level.
    fn run<R: Registers<f32>>(self, registers: R) -> Self::Output;
}

pub(crate) mod private {
    /// Registers are those of the levels of this crate.
    pub trait Sealed {}
}

/// The `N` entries of a slice from an index on.
#[allow(clippy::inline_always, reason = "part of loops inside a dispatched function")]
#[inline(always)]
pub(crate) fn chunk<T, const N: usize>(slice: &[T], at: usize) -> &[T; N] {
    slice[at..at + N].first_chunk().expect("a slice of N")
}

/// As [`chunk`], to write.
#[allow(clippy::inline_always, reason = "part of loops inside a dispatched function")]
#[inline(always)]
pub(crate) fn chunk_mut<T, const N: usize>(slice: &mut [T], at: usize) -> &mut [T; N] {
    slice[at..at + N].first_chunk_mut().expect("a slice of N")
}

/// Slices as blocks of so many lanes.
macro_rules! blocks {
    ($n:expr) => {
        const N: usize = $n;
        type Block = [f32; $n];
        type Indices = [u32; $n];

        #[inline(always)]
        fn blocks(values: &[f32]) -> &[Self::Block] {
            values.as_chunks().0
        }
        #[inline(always)]
        fn index_blocks(indices: &[u32]) -> &[Self::Indices] {
            indices.as_chunks().0
        }
        #[inline(always)]
        fn block_at(values: &[f32], at: usize) -> &Self::Block {
            $crate::registers::chunk(values, at)
        }
        #[inline(always)]
        fn indices_at(indices: &[u32], at: usize) -> &Self::Indices {
            $crate::registers::chunk(indices, at)
        }
    };
}
pub(crate) use blocks;
