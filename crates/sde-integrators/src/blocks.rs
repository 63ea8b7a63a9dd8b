//! Parallel sums over realisations that are bitwise independent of the number of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Realisations per block: block `b` holds the numbers from `4096 b` to `4096 (b + 1)`.
pub const BLOCK_LENGTH: u64 = 4096;

/// Computes a result for each block of realisations and merges the results pairwise.
///
/// The shape of the merge tree depends on `n_realisations` alone. `block` gets a range of at most [`BLOCK_LENGTH`]
/// numbers; `merge(earlier, later)` joins neighbours. With the feature `rayon` the blocks run in parallel on the
/// current pool, otherwise in order; results are bitwise identical. Returns `None` for no realisations.
///
/// # Errors
/// The error of the lowest block that failed. Blocks above it may be skipped.
pub fn reduce_blocks<T, E, B, M>(n_realisations: u64, block: B, merge: M) -> Result<Option<T>, E>
where
    T: Send,
    E: Send,
    B: Fn(Range<u64>) -> Result<T, E> + Sync,
    M: Fn(T, T) -> T + Sync,
{
    reduce_blocks_of(BLOCK_LENGTH, n_realisations, block, merge)
}

/// [`reduce_blocks`] with blocks of another length, at least 1.
pub(crate) fn reduce_blocks_of<T, E, B, M>(
    length: u64,
    n_realisations: u64,
    block: B,
    merge: M,
) -> Result<Option<T>, E>
where
    T: Send,
    E: Send,
    B: Fn(Range<u64>) -> Result<T, E> + Sync,
    M: Fn(T, T) -> T + Sync,
{
    let lowest_failed = AtomicU64::new(u64::MAX);
    let tree = Tree { length, n_realisations, lowest_failed, block, merge };
    match tree.reduce(0, n_realisations.div_ceil(length)) {
        Ok(result) => Ok(result),
        Err(Failure::Block(error)) => Err(error),
        // A block is skipped only above one that failed, whose error is found first.
        Err(Failure::LeftOut) => unreachable!("a block was left out, but none below it failed"),
    }
}

enum Failure<E> {
    Block(E),
    LeftOut,
}

struct Tree<B, M> {
    /// Realisations per block.
    length: u64,
    n_realisations: u64,
    /// The lowest block known to have failed: blocks above it need not run.
    lowest_failed: AtomicU64,
    block: B,
    merge: M,
}

impl<B, M> Tree<B, M> {
    /// Reduces blocks `from..to`, split where the lower half is the largest power of two.
    fn reduce<T, E>(&self, from: u64, to: u64) -> Result<Option<T>, Failure<E>>
    where
        T: Send,
        E: Send,
        B: Fn(Range<u64>) -> Result<T, E> + Sync,
        M: Fn(T, T) -> T + Sync,
    {
        match to - from {
            0 => Ok(None),
            1 => self.run(from).map(Some),
            n_blocks => {
                let middle = from + n_blocks.div_ceil(2).next_power_of_two();
                let (lower, upper) = join(|| self.reduce(from, middle), || self.reduce(middle, to));
                Ok(match (lower?, upper?) {
                    (Some(earlier), Some(later)) => Some((self.merge)(earlier, later)),
                    (one, other) => one.or(other),
                })
            }
        }
    }

    fn run<T, E>(&self, block: u64) -> Result<T, Failure<E>>
    where
        B: Fn(Range<u64>) -> Result<T, E>,
    {
        if block > self.lowest_failed.load(Ordering::Relaxed) {
            return Err(Failure::LeftOut);
        }
        (self.block)(realisations((self.length, self.n_realisations), block)).map_err(|error| {
            self.lowest_failed.fetch_min(block, Ordering::Relaxed);
            Failure::Block(error)
        })
    }
}

/// Results of all blocks of a range, in order.
#[cfg(feature = "rayon")]
pub(crate) fn map_blocks<T: Send>(
    n_realisations: u64,
    blocks: Range<u64>,
    block: impl Fn(Range<u64>) -> T + Sync,
) -> Vec<T> {
    use rayon::iter::{IntoParallelIterator, ParallelIterator};
    let blocks: Vec<u64> = blocks.collect();
    blocks.into_par_iter().map(|b| block(realisations((BLOCK_LENGTH, n_realisations), b))).collect()
}

/// Results of all blocks of a range, in order.
#[cfg(not(feature = "rayon"))]
pub(crate) fn map_blocks<T: Send>(
    n_realisations: u64,
    blocks: Range<u64>,
    block: impl Fn(Range<u64>) -> T + Sync,
) -> Vec<T> {
    blocks.map(|b| block(realisations((BLOCK_LENGTH, n_realisations), b))).collect()
}

fn realisations((length, n_realisations): (u64, u64), block: u64) -> Range<u64> {
    let start = block * length;
    start..n_realisations.min(start.saturating_add(length))
}

/// Merges the results of all blocks, in order, in the tree of [`reduce_blocks`]; `None` for no blocks.
///
/// `result` takes the result of a block; `merge(earlier, later)` joins neighbours. Blocks computed apart thus have the sum of
/// one run, bit for bit.
pub fn reduce_in_tree<B, T>(
    blocks: &[B],
    result: &impl Fn(&B) -> T,
    merge: &impl Fn(T, T) -> T,
) -> Option<T> {
    match blocks {
        [] => None,
        [block] => Some(result(block)),
        _ => {
            let (lower, upper) = blocks.split_at(blocks.len().div_ceil(2).next_power_of_two());
            match (reduce_in_tree(lower, result, merge), reduce_in_tree(upper, result, merge)) {
                (Some(earlier), Some(later)) => Some(merge(earlier, later)),
                (one, other) => one.or(other),
            }
        }
    }
}

#[cfg(feature = "rayon")]
fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

#[cfg(not(feature = "rayon"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    let first = a();
    (first, b())
}
