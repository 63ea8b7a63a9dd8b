//! Loops over particles whose every output bit is the same for any number of threads: each particle writes its own
//! entry, and nothing is summed across particles here.

/// Particles that one thread takes at a time: fewer would cost more to hand out than to compute.
pub(crate) const BLOCK: usize = 128;

/// Largest number of particles whose loops run on the calling thread. An evaluation has about ten loops over the particles;
/// with so few each takes microseconds, as long as it takes to wake another thread.
const FEW: usize = 1024;

/// Whether loops over so many particles are shared between threads.
pub(crate) const fn is_shared(n: usize) -> bool {
    cfg!(feature = "rayon") && n > FEW
}

/// Runs work inside the thread pool, so that its parallel loops do not each wait for a worker to wake; with few particles, on
/// the calling thread.
pub(crate) fn in_pool<R: Send>(n_particles: usize, work: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "rayon")]
    if is_shared(n_particles) && rayon::current_thread_index().is_none() {
        return rayon::scope(|_| work());
    }
    let _ = n_particles;
    work()
}

/// `out[i] = value(i)`.
pub(crate) fn fill<T: Send>(out: &mut [T], value: impl Fn(usize) -> T + Sync) {
    for_each_block(out, &|first, block| {
        for (i, entry) in (first..).zip(block) {
            *entry = value(i);
        }
    });
}

/// `write(first, block)` for blocks of at most [`BLOCK`] entries, the first of which is `out[first]`. A pointer to the
/// function, so that the threads' code is compiled once per type of entry.
pub(crate) fn for_each_block<T: Send>(out: &mut [T], write: &(dyn Fn(usize, &mut [T]) + Sync)) {
    #[cfg(feature = "rayon")]
    if is_shared(out.len()) {
        use rayon::prelude::*;
        return out
            .par_chunks_mut(BLOCK)
            .enumerate()
            .for_each(|(k, block)| write(k * BLOCK, block));
    }
    for (k, block) in out.chunks_mut(BLOCK).enumerate() {
        write(k * BLOCK, block);
    }
}

/// Slices that are split at the same point, for threads that write disjoint parts.
pub(crate) trait Split: Send + Sized {
    /// Number of entries.
    fn n(&self) -> usize;
    /// The entries before `at`, and the others.
    fn split(self, at: usize) -> (Self, Self);
}

impl<T: Send> Split for &mut [T] {
    fn n(&self) -> usize {
        self.len()
    }

    fn split(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
}

impl<A: Split, B: Split> Split for (A, B) {
    fn n(&self) -> usize {
        self.0.n()
    }

    fn split(self, at: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.split(at), self.1.split(at));
        ((a, b), (c, d))
    }
}

/// `write(k, part)` for the parts of `size` entries each, the last of which may be shorter.
pub(crate) fn for_each_part<S: Split>(out: S, size: usize, write: &(impl Fn(usize, S) + Sync)) {
    let shared = is_shared(out.n());
    from_part(0, out, (size, shared), write);
}

/// As [`for_each_part`], with parts counted from `first`.
fn from_part<S: Split>(
    first: usize,
    out: S,
    (size, shared): (usize, bool),
    write: &(impl Fn(usize, S) + Sync),
) {
    let n_parts = out.n().div_ceil(size);
    if n_parts <= 1 {
        return write(first, out);
    }
    let half = n_parts / 2;
    let (low, high) = out.split(half * size);
    let how = (size, shared);
    let low = || from_part(first, low, how, write);
    let high = || from_part(first + half, high, how, write);
    #[cfg(feature = "rayon")]
    if shared {
        rayon::join(low, high);
        return;
    }
    low();
    high();
}
