//! Sums over realisations whose bits do not depend on the number of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Realisations per block: block `b` holds the numbers from `4096 b` to `4096 (b + 1)`.
pub const BLOCK_LENGTH: u64 = 4096;

/// Compute a result per block of realisation numbers and merge them pairwise, in a tree whose shape depends on
/// `n_realisations` alone.
///
/// `block` gets a range of at most [`BLOCK_LENGTH`] numbers; `merge(earlier, later)` joins neighbours. With the feature
/// `rayon` the blocks run in parallel on the current pool, without it in order; the bits are the same.
/// Returns `None` where there is nothing to do.
///
/// # Errors
/// The error of the lowest block that failed. Blocks above it may be left out.
pub fn reduce_blocks<T, E, B, M>(n_realisations: u64, block: B, merge: M) -> Result<Option<T>, E>
where
    T: Send,
    E: Send,
    B: Fn(Range<u64>) -> Result<T, E> + Sync,
    M: Fn(T, T) -> T + Sync,
{
    let tree = Tree { n_realisations, lowest_failed: AtomicU64::new(u64::MAX), block, merge };
    match tree.reduce(0, n_realisations.div_ceil(BLOCK_LENGTH)) {
        Ok(result) => Ok(result),
        Err(Failure::Block(error)) => Err(error),
        // A block is left out only above one that failed, whose error is then found first.
        Err(Failure::LeftOut) => unreachable!("a block was left out, but none below it failed"),
    }
}

enum Failure<E> {
    Block(E),
    LeftOut,
}

struct Tree<B, M> {
    n_realisations: u64,
    /// The lowest block known to have failed: blocks above it need not run.
    lowest_failed: AtomicU64,
    block: B,
    merge: M,
}

impl<B, M> Tree<B, M> {
    /// Blocks `from..to`, split where the lower half is the largest power of two.
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
        let start = block * BLOCK_LENGTH;
        let end = self.n_realisations.min(start.saturating_add(BLOCK_LENGTH));
        (self.block)(start..end).map_err(|error| {
            self.lowest_failed.fetch_min(block, Ordering::Relaxed);
            Failure::Block(error)
        })
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
