//! Work whose every output bit is the same for any number of threads: each entry is written once, from data that nobody
//! writes, and sums have a shape that lengths alone decide. Nothing here allocates but the results of [`map_in_order`].
//!
//! A step runs in the pool of threads as a whole: started outside, each of its passes would wait for another thread to wake. With few
//! particles it stays on the thread that asks for it.
//!
//! Work is behind `dyn`: what hands it to threads is compiled once, not for every closure.

/// Pieces of the work for each thread: enough that none waits long for another.
#[cfg(feature = "rayon")]
const PIECES: usize = 16;

/// Particles up to which a step offers no work to other threads: its passes take as long as waking one.
#[cfg(feature = "rayon")]
const FEW: usize = 1024;

#[cfg(feature = "rayon")]
thread_local! {
    /// Whether this thread is in a step of few particles.
    static ALONE: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Runs a step of so many particles: in the pool of threads, or with few particles on this one.
pub(crate) fn in_pool<R: Send>(n_particles: usize, step: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "rayon")]
    if n_particles > FEW {
        return if rayon::current_thread_index().is_none() {
            rayon::scope(|_| step())
        } else {
            step()
        };
    }
    #[cfg(feature = "rayon")]
    ALONE.set(true);
    let _ = n_particles;
    let result = step();
    #[cfg(feature = "rayon")]
    ALONE.set(false);
    result
}

/// Runs both, at once where there are threads.
pub(crate) fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    #[cfg(feature = "rayon")]
    if !ALONE.get() {
        rayon::join(a, b);
        return;
    }
    a();
    b();
}

/// How many of `n` chunks one thread works on without offering any to another.
fn piece_of(n: usize) -> usize {
    #[cfg(feature = "rayon")]
    if !ALONE.get() {
        return n.div_ceil(PIECES * rayon::current_num_threads());
    }
    n
}

/// `work(k, chunk k)` for every run of `length` entries, which is much work.
pub(crate) fn for_each_chunk<T: Send>(
    entries: &mut [T],
    length: usize,
    work: &(dyn Fn(usize, &mut [T]) + Sync),
) {
    // Beside a column of nothing, which takes no memory.
    let mut nothing = vec![(); entries.len()];
    for_each_pair_of_chunks((entries, &mut nothing), length, &|k, chunk, _| work(k, chunk));
}

/// Work on a chunk of each of two columns, by their number.
type OfPairs<'a, T, U> = dyn Fn(usize, &mut [T], &mut [U]) + Sync + 'a;

/// `work(k, chunk k of one, chunk k of two)` for every run of `length` entries of both, which is much work.
pub(crate) fn for_each_pair_of_chunks<T: Send, U: Send>(
    (one, two): (&mut [T], &mut [U]),
    length: usize,
    work: &OfPairs<'_, T, U>,
) {
    let piece = piece_of(one.len().div_ceil(length));
    pairs_in_halves((0, one, two), (length, piece), work);
}

fn pairs_in_halves<T: Send, U: Send>(
    (first, one, two): (usize, &mut [T], &mut [U]),
    lengths: (usize, usize),
    work: &OfPairs<'_, T, U>,
) {
    let (length, piece) = lengths;
    let n = one.len().div_ceil(length);
    if n > piece {
        let middle = n / 2;
        let (low, high) = one.split_at_mut(middle * length);
        let (low_two, high_two) = two.split_at_mut(middle * length);
        join(
            &mut || pairs_in_halves((first, &mut *low, &mut *low_two), lengths, work),
            &mut || {
                pairs_in_halves((first + middle, &mut *high, &mut *high_two), lengths, work);
            },
        );
        return;
    }
    for (k, (one, two)) in one.chunks_mut(length).zip(two.chunks_mut(length)).enumerate() {
        work(first + k, one, two);
    }
}

/// `work(entry)` for every entry, each much work; results in the order of the entries.
pub(crate) fn map_in_order<T: Sync, U: Send>(
    entries: &[T],
    work: &(dyn Fn(&T) -> U + Sync),
) -> Vec<U> {
    let mut results: Vec<Option<U>> = entries.iter().map(|_| None).collect();
    let each =
        |k: usize, result: &mut [Option<U>], _: &mut [()]| result[0] = Some(work(&entries[k]));
    let mut nothing = vec![(); entries.len()];
    pairs_in_halves((0, &mut results, &mut nothing), (1, 1), &each);
    results.into_iter().flatten().collect()
}
