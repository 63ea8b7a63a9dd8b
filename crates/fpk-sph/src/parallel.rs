//! Loops over particles whose every output bit is the same for any number of threads: each particle writes its own
//! entry, and nothing is summed across particles here.

use crate::error::Error;
use crate::score::{Estimates, Fits};

/// Particles that one thread takes at a time: fewer would cost more to hand out than to compute.
pub(crate) const BLOCK: usize = 128;

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
    {
        use rayon::prelude::*;
        out.par_chunks_mut(BLOCK).enumerate().for_each(|(k, block)| write(k * BLOCK, block));
    }
    #[cfg(not(feature = "rayon"))]
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
    from_part(0, out, size, write);
}

/// As [`for_each_part`], with parts counted from `first`.
fn from_part<S: Split>(first: usize, out: S, size: usize, write: &(impl Fn(usize, S) + Sync)) {
    let n_parts = out.n().div_ceil(size);
    if n_parts <= 1 {
        return write(first, out);
    }
    let half = n_parts / 2;
    let (low, high) = out.split(half * size);
    let (low, high) =
        (|| from_part(first, low, size, write), || from_part(first + half, high, size, write));
    #[cfg(feature = "rayon")]
    rayon::join(low, high);
    #[cfg(not(feature = "rayon"))]
    {
        low();
        high();
    }
}

/// `(score, density, volume)[i] = value(i)`.
pub(crate) fn for_each_particle<const D: usize>(
    out: &mut Estimates<D>,
    value: impl Fn(usize) -> ([f64; D], f64, f64) + Sync,
) {
    let write = |i: usize, score: &mut [f64; D], density: &mut f64, volume: &mut f64| {
        (*score, *density, *volume) = value(i);
    };
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        out.score
            .par_iter_mut()
            .zip(out.density.par_iter_mut())
            .zip(out.volume.par_iter_mut())
            .enumerate()
            .with_min_len(BLOCK)
            .for_each(|(i, ((score, density), volume))| write(i, score, density, volume));
    }
    #[cfg(not(feature = "rayon"))]
    for i in 0..out.score.len() {
        write(i, &mut out.score[i], &mut out.density[i], &mut out.volume[i]);
    }
}

/// `(score, volume)[i] = value(scratch, i)`, and how well the fits were determined; of several errors, that of the lowest
/// particle. Counts and a smallest value do not depend on what the threads did.
pub(crate) fn for_each_fit<const D: usize, W>(
    score: &mut [[f64; D]],
    volume: &mut [f64],
    scratch: impl Fn() -> W + Sync + Send,
    value: impl Fn(&mut W, usize) -> Result<([f64; D], f64, Fits), Error> + Sync + Send,
) -> Result<Fits, Error> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        type Outcome = Result<Fits, (usize, Error)>;
        let both = |one: Outcome, other: Outcome| match (one, other) {
            (Ok(one), Ok(other)) => Ok(one.and(other)),
            (Err(one), Err(other)) => Err(if other.0 < one.0 { other } else { one }),
            (Err(error), Ok(_)) | (Ok(_), Err(error)) => Err(error),
        };
        score
            .par_chunks_mut(BLOCK)
            .zip(volume.par_chunks_mut(BLOCK))
            .enumerate()
            .map(|(chunk, (score, volume))| {
                let (mut scratch, mut all) = (scratch(), Fits::default());
                for (i, (score, volume)) in (chunk * BLOCK..).zip(score.iter_mut().zip(volume)) {
                    let fits;
                    (*score, *volume, fits) = value(&mut scratch, i).map_err(|error| (i, error))?;
                    all = all.and(fits);
                }
                Ok(all)
            })
            .reduce(|| Ok(Fits::default()), both)
            .map_err(|(_, error)| error)
    }
    #[cfg(not(feature = "rayon"))]
    {
        let (mut scratch, mut all) = (scratch(), Fits::default());
        for (i, (score, volume)) in score.iter_mut().zip(volume).enumerate() {
            let fits;
            (*score, *volume, fits) = value(&mut scratch, i)?;
            all = all.and(fits);
        }
        Ok(all)
    }
}
