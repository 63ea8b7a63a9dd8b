//! Parallel loops over stretches of memory.
//!
//! Each thread writes its own stretch, so results do not depend on thread scheduling.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// A thousand rows: their numbers, memory, ends, and the work data of a thread.
pub(crate) struct Part<'a, S> {
    pub(crate) chunk: usize,
    pub(crate) indices: &'a mut Vec<u32>,
    pub(crate) ends: &'a mut [usize],
    pub(crate) scratch: &'a mut S,
}

/// Calls `work` for every chunk of rows, with one `scratch` for each chunk.
pub(crate) fn for_each_part<S: Send>(
    chunks: &mut [Vec<u32>],
    ends: &mut [usize],
    size: usize,
    scratch: &mut [S],
    work: impl Fn(Part<'_, S>) + Sync + Send,
) {
    let part = |(chunk, ((indices, ends), scratch))| Part { chunk, indices, ends, scratch };
    // One chunk is done here: waking a thread of the pool takes longer than small lists.
    #[cfg(feature = "rayon")]
    if chunks.len() > 1 {
        return chunks
            .par_iter_mut()
            .zip(ends.par_chunks_mut(size))
            .zip(scratch.par_iter_mut())
            .enumerate()
            .map(part)
            .for_each(work);
    }
    chunks.iter_mut().zip(ends.chunks_mut(size)).zip(scratch).enumerate().map(part).for_each(work);
}

/// Length of the stretch of a column that one thread writes.
const STRETCH: usize = 4096;

/// `out[k] = value(k)`.
pub(crate) fn fill<T: Send>(out: &mut [T], value: impl Fn(usize) -> T + Sync + Send) {
    let write = |(stretch, out): (usize, &mut [T])| {
        for (k, entry) in out.iter_mut().enumerate() {
            *entry = value(stretch * STRETCH + k);
        }
    };
    #[cfg(feature = "rayon")]
    if out.len() > STRETCH {
        return out.par_chunks_mut(STRETCH).enumerate().for_each(write);
    }
    out.chunks_mut(STRETCH).enumerate().for_each(write);
}

/// `out[k] = value(from[k])`.
pub(crate) fn fill_from<S: Sync, T: Send>(
    out: &mut [T],
    from: &[S],
    value: impl Fn(&S) -> T + Sync + Send,
) {
    let write = |(out, from): (&mut [T], &[S])| {
        for (entry, from) in out.iter_mut().zip(from) {
            *entry = value(from);
        }
    };
    #[cfg(feature = "rayon")]
    if out.len() > STRETCH {
        return out.par_chunks_mut(STRETCH).zip(from.par_chunks(STRETCH)).for_each(write);
    }
    out.chunks_mut(STRETCH).zip(from.chunks(STRETCH)).for_each(write);
}

/// Divides two slices into stretches of the given lengths and calls `work(k, stretch, stretch)` for each pair.
pub(crate) fn for_each_pair_of_stretches<A: Send, B: Send>(
    (a, b): (&mut [A], &mut [B]),
    lengths: &[[usize; 2]],
    work: &(impl Fn(usize, &mut [A], &mut [B]) + Sync + Send),
) {
    divide(0, a, b, lengths, work);
}

fn divide<A: Send, B: Send>(
    first: usize,
    a: &mut [A],
    b: &mut [B],
    lengths: &[[usize; 2]],
    work: &(impl Fn(usize, &mut [A], &mut [B]) + Sync + Send),
) {
    if lengths.len() <= 1 {
        return work(first, a, b);
    }
    let (left, right) = lengths.split_at(lengths.len() / 2);
    let cut = left.iter().fold([0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    let (a, a_rest) = a.split_at_mut(cut[0]);
    let (b, b_rest) = b.split_at_mut(cut[1]);
    join(
        || divide(first, a, b, left, work),
        || divide(first + left.len(), a_rest, b_rest, right, work),
    );
}

/// Runs both, on two threads if available.
pub(crate) fn join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    #[cfg(feature = "rayon")]
    rayon::join(a, b);
    #[cfg(not(feature = "rayon"))]
    {
        a();
        b();
    }
}

/// Number of available threads.
pub(crate) fn threads() -> usize {
    #[cfg(feature = "rayon")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    return 1;
}
