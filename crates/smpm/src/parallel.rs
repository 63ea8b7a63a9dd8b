//! Work whose every output bit is the same for any number of threads: each entry is written once, from data that nobody
//! writes, and sums have a shape that lengths alone decide. Nothing here allocates.

/// Both, at once where there are threads.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    {
        rayon::join(a, b)
    }
    #[cfg(not(feature = "rayon"))]
    {
        (a(), b())
    }
}

/// `work(k, chunk k)` for every run of `length` entries, which is much work.
pub(crate) fn for_each_chunk<T: Send>(
    entries: &mut [T],
    length: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        entries.par_chunks_mut(length).enumerate().for_each(|(k, chunk)| work(k, chunk));
    }
    #[cfg(not(feature = "rayon"))]
    for (k, chunk) in entries.chunks_mut(length).enumerate() {
        work(k, chunk);
    }
}

/// `work(k, chunk k of one, chunk k of two)` for every run of `length` entries of both, which is much work.
pub(crate) fn for_each_pair_of_chunks<T: Send, U: Send>(
    (one, two): (&mut [T], &mut [U]),
    length: usize,
    work: impl Fn(usize, &mut [T], &mut [U]) + Sync,
) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        let pairs = one.par_chunks_mut(length).zip(two.par_chunks_mut(length));
        pairs.enumerate().for_each(|(k, (one, two))| work(k, one, two));
    }
    #[cfg(not(feature = "rayon"))]
    for (k, (one, two)) in one.chunks_mut(length).zip(two.chunks_mut(length)).enumerate() {
        work(k, one, two);
    }
}

/// `work(entry)` for every entry, each much work; results in the order of the entries.
pub(crate) fn map_in_order<T: Sync, U: Send>(
    entries: &[T],
    work: impl Fn(&T) -> U + Sync + Send,
) -> Vec<U> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        entries.par_iter().with_max_len(1).map(work).collect()
    }
    #[cfg(not(feature = "rayon"))]
    entries.iter().map(work).collect()
}
