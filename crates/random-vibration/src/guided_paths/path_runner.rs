//! Runs sets of guided paths: all that depends on the type of a system and of its method.

use std::ops::Range;

use sde_integrators::{Error, Guide, GuidedEnsemble, GuidedPath, LanePaths, Passages};

use crate::guided_paths::event::Event;
use crate::guided_paths::weights::Contributions;
use crate::guides::backward::Start;

/// Largest number of steps: the guides of all strengths then take two gigabytes with four states.
const MOST_STEPS: usize = 1 << 22;
/// Number of paths per block, and the number of blocks of a set above which blocks are longer.
const BLOCK: (u64, u64) = (512, 1024);
/// Largest number of paths per block: what is computed between two looks at the time that a run takes.
const LONGEST: u64 = 32_768;

/// Paths of a system from a start.
pub(crate) struct PathRunner<'a> {
    runner: Box<Runner<'a>>,
    pub(crate) start: Start,
    pub(crate) dt: f64,
    /// Largest number of steps.
    pub(crate) n_steps: usize,
}

/// A set of paths with the same guides.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathSet<'r> {
    pub(crate) guides: &'r [Guide],
    pub(crate) passages: Option<Passages<'r>>,
    pub(crate) seed: u64,
    pub(crate) n_steps: usize,
    /// First realisation and number of paths.
    pub(crate) realisations: (u64, u64),
}

/// Sums over one block of a set of guided paths: one for each event.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathBlock {
    pub(crate) sums: Vec<Contributions>,
}

/// Adds a path to sums.
type Collect<'c> = &'c (dyn Fn(&GuidedPath<'_>, &mut [Contributions]) + Sync + 'c);

/// Runs blocks of a set, each with a number of sums.
type Runner<'a> = dyn Fn(&PathSet<'_>, Range<u64>, usize, Collect<'_>) -> Result<Vec<PathBlock>, Error>
    + Sync
    + 'a;

impl std::fmt::Debug for PathRunner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { start, dt, n_steps, .. } = self;
        f.debug_struct("PathRunner")
            .field("start", start)
            .field("dt", dt)
            .field("n_steps", n_steps)
            .finish_non_exhaustive()
    }
}

impl<'a> PathRunner<'a> {
    pub(crate) fn new<P: LanePaths<M> + 'a, const M: usize>(
        paths: P,
        start: Start,
        (time, n_steps): (f64, usize),
    ) -> Self {
        let dt = time / n_steps as f64;
        let Start { mean, factor } = start.clone();
        let runner = move |set: &PathSet<'_>, blocks: Range<u64>, n_sums, collect: Collect<'_>| {
            let PathSet { guides, passages, seed, n_steps, realisations: (first, n) } = *set;
            let (paths, mean, factor) = (&paths, &mean[..], &factor[..]);
            let ensemble =
                GuidedEnsemble::<_, M> { paths, mean, factor, dt, n_steps, guides, passages, seed };
            let new = || PathBlock { sums: vec![Contributions::default(); n_sums] };
            let push =
                |block: &mut PathBlock, path: &GuidedPath<'_>| collect(path, &mut block.sums);
            let paths = (first..first + n, block_length(n));
            ensemble.blocks(paths, blocks, new, push)
        };
        Self { runner: Box::new(runner), start, dt, n_steps }
    }

    pub(crate) fn n_states(&self) -> usize {
        self.start.mean.len()
    }

    /// Blocks of a set, with sums that `collect` fills.
    pub(crate) fn collected(
        &self,
        set: &PathSet<'_>,
        blocks: Range<u64>,
        n_sums: usize,
        collect: Collect<'_>,
    ) -> Result<Vec<PathBlock>, Error> {
        (self.runner)(set, blocks, n_sums, collect)
    }

    /// Blocks of a set, with the contributions of its paths to the probability of each event.
    pub(crate) fn blocks(
        &self,
        set: &PathSet<'_>,
        blocks: Range<u64>,
        events: &[Event<'_>],
    ) -> Result<Vec<PathBlock>, Error> {
        self.collected(set, blocks, events.len(), &|path, sums| {
            for (sum, event) in sums.iter_mut().zip(events) {
                let known = event.known(path);
                sum.push(known.map(|known| event.sides() * known.log_weight.exp()));
            }
        })
    }
}

/// Number of blocks of a set. It depends on the number of paths alone.
pub(crate) const fn n_blocks(n_paths: u64) -> u64 {
    n_paths.div_ceil(block_length(n_paths))
}

const fn block_length(n_paths: u64) -> u64 {
    let (unit, most) = BLOCK;
    let multiple = n_paths.div_ceil(unit * most);
    let most = LONGEST / unit;
    unit * if multiple == 0 {
        1
    } else if multiple > most {
        most
    } else {
        multiple
    }
}

/// Numbers of paths in the blocks of a set, in order.
pub(crate) fn block_lengths(n_paths: u64) -> impl Iterator<Item = u64> {
    let length = block_length(n_paths);
    (0..n_blocks(n_paths)).map(move |block| length.min(n_paths - block * length))
}

/// Rejects a time and a number of steps that cannot be simulated.
pub(crate) fn check_span((time, n_steps): (f64, usize)) -> Result<(), Error> {
    if !(time > 0.0 && time.is_finite()) {
        return Err(Error::NotPositive { quantity: "time", value: time });
    }
    if n_steps == 0 {
        return Err(Error::TooFew { quantity: "steps", value: 0, limit: 1 });
    }
    if n_steps > MOST_STEPS {
        let (value, limit) = (n_steps as f64, MOST_STEPS as f64);
        return Err(Error::TooMany { quantity: "steps of guided paths", value, limit });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_a_thousand_blocks_before_they_grow_and_none_is_longer_than_the_longest() {
        let (unit, most) = BLOCK;
        for n in [1, 2, 511, 512, 513, 20_000, unit * most, unit * most + 1, 1 << 25, 1 << 30] {
            let (blocks, length) = (n_blocks(n), block_length(n));
            assert!(length % unit == 0 && length <= LONGEST, "{n}: {blocks} of {length}");
            assert!(blocks <= most || length == LONGEST, "{n}: {blocks} of {length}");
            assert!((blocks - 1) * length < n && n <= blocks * length, "{n}: {blocks} of {length}");
            assert_eq!(block_lengths(n).sum::<u64>(), n);
        }
    }
}
