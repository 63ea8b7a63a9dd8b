//! Loops whose every output bit is the same for any number of threads: each entry is written once, from data that nobody
//! writes.

/// Entries that one thread takes at a time.
#[cfg(feature = "rayon")]
const GRAIN: usize = 256;

/// `work(i, entry i)` for every entry.
pub(crate) fn for_each<T: Send>(entries: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        entries
            .par_iter_mut()
            .enumerate()
            .with_min_len(GRAIN)
            .for_each(|(i, entry)| work(i, entry));
    }
    #[cfg(not(feature = "rayon"))]
    for (i, entry) in entries.iter_mut().enumerate() {
        work(i, entry);
    }
}

/// As [`for_each`], for entries that are much work each.
pub(crate) fn for_each_large<T: Send>(entries: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        entries.par_iter_mut().enumerate().for_each(|(i, entry)| work(i, entry));
    }
    #[cfg(not(feature = "rayon"))]
    for (i, entry) in entries.iter_mut().enumerate() {
        work(i, entry);
    }
}

/// `work(i, a_i, b_i)` for every pair of entries.
pub(crate) fn for_each_pair<A: Send, B: Send>(
    a: &mut [A],
    b: &mut [B],
    work: impl Fn(usize, &mut A, &mut B) + Sync,
) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        a.par_iter_mut()
            .zip(b.par_iter_mut())
            .enumerate()
            .with_min_len(GRAIN)
            .for_each(|(i, (a, b))| work(i, a, b));
    }
    #[cfg(not(feature = "rayon"))]
    for (i, (a, b)) in a.iter_mut().zip(b).enumerate() {
        work(i, a, b);
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
