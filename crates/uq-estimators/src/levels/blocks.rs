//! Blocks of samples of a ladder: what is planned, what is known.

use std::ops::Range;

use sde_integrators::reduce_in_tree;

use crate::comoments::Comoments;
use crate::error::Error;
use crate::ladder::Pair;

/// Address of a block of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BlockId {
    /// The levels that each sample runs.
    pub pair: Pair,
    /// Number of the block among those of the pair.
    pub block: u64,
}

/// Sums over the samples of one block.
///
/// With the feature `serde` it can be written and read, in a format that keeps all bits of a number (`float_roundtrip` in
/// serde_json).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Block {
    pub(crate) study: String,
    pub(crate) id: BlockId,
    /// For each target.
    pub(crate) sums: Vec<Comoments>,
}

impl Block {
    /// Its address.
    #[must_use]
    pub const fn id(&self) -> BlockId {
        self.id
    }
}

/// State of a multilevel estimate: the blocks that are planned and those that have been computed.
///
/// The plan depends on the blocks alone, never on the order of their arrival: an estimate that was interrupted, or whose
/// blocks were computed apart, is bitwise identical to one that ran through.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Progress {
    pub(crate) study: String,
    pub(crate) block_length: u64,
    /// One response per entry, near its mean: what variances are sampled about.
    pub(crate) centres: Vec<f64>,
    /// Number of blocks planned for each pair, in order.
    planned: Vec<(Pair, u64)>,
    /// In the order of their addresses.
    blocks: Vec<Block>,
}

impl Progress {
    pub(crate) const fn new(study: String, block_length: u64, centres: Vec<f64>) -> Self {
        Self { study, block_length, centres, planned: Vec::new(), blocks: Vec::new() }
    }

    /// Addresses of the blocks that are planned and not yet known, in order.
    #[must_use]
    pub fn missing(&self) -> Vec<BlockId> {
        let all = self
            .planned
            .iter()
            .flat_map(|&(pair, n_blocks)| (0..n_blocks).map(move |block| BlockId { pair, block }));
        all.filter(|id| self.place(id).is_err()).collect()
    }

    /// Adds a block, in any order.
    ///
    /// # Errors
    /// [`Error::ForeignBlock`] for one of another study, [`Error::UnwantedBlock`] for one that is not missing.
    pub fn insert(&mut self, block: Block) -> Result<(), Error> {
        if block.study != self.study {
            let (value, expected) = (block.study, self.study.clone());
            return Err(Error::ForeignBlock { field: "name", value, expected });
        }
        let n_samples = {
            let range = samples_of(self.block_length, block.id.block);
            range.end - range.start
        };
        let count = block.sums.first().map_or(0, Comoments::count);
        if count != n_samples {
            let (value, expected) = (count.to_string(), n_samples.to_string());
            return Err(Error::ForeignBlock { field: "number of samples", value, expected });
        }
        let is_planned = block.id.block < self.n_blocks(block.id.pair);
        match self.place(&block.id) {
            Err(place) if is_planned => {
                self.blocks.insert(place, block);
                Ok(())
            }
            _ => {
                Err(Error::UnwantedBlock { pair: block.id.pair.to_string(), block: block.id.block })
            }
        }
    }

    fn place(&self, id: &BlockId) -> Result<usize, usize> {
        self.blocks.binary_search_by_key(id, |block| block.id)
    }

    pub(crate) fn require_complete(&self) -> Result<(), Error> {
        let missing = self.missing();
        missing.first().map_or(Ok(()), |first| {
            let (pair, block) = (first.pair.to_string(), first.block);
            Err(Error::MissingBlocks { missing: missing.len(), pair, block })
        })
    }

    /// Number of blocks planned for a pair.
    pub(crate) fn n_blocks(&self, pair: Pair) -> u64 {
        self.planned.iter().find(|planned| planned.0 == pair).map_or(0, |planned| planned.1)
    }

    /// All pairs with blocks planned, in order.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (Pair, u64)> + '_ {
        self.planned.iter().copied()
    }

    /// Plans so many blocks of a pair, if there are fewer; returns whether it did.
    pub(crate) fn plan(&mut self, pair: Pair, n_blocks: u64) -> bool {
        match self.planned.binary_search_by_key(&pair, |planned| planned.0) {
            Ok(place) if self.planned[place].1 >= n_blocks => return false,
            Ok(place) => self.planned[place].1 = n_blocks,
            Err(place) => self.planned.insert(place, (pair, n_blocks)),
        }
        true
    }

    /// Sums over the first blocks of a pair, for each target.
    pub(crate) fn sums(&self, pair: Pair, most_blocks: u64) -> Option<Vec<Comoments>> {
        let start = self.blocks.partition_point(|block| block.id.pair < pair);
        let of_pair = self.blocks[start..].iter();
        let blocks: Vec<&Block> =
            of_pair.take_while(|b| b.id.pair == pair && b.id.block < most_blocks).collect();
        let join = |mut earlier: Vec<Comoments>, later: Vec<Comoments>| {
            for (sums, later) in earlier.iter_mut().zip(&later) {
                sums.merge(later);
            }
            earlier
        };
        reduce_in_tree(&blocks, &|block| block.sums.clone(), &join)
    }
}

/// Samples before a further block, over its own: blocks grow, so their number grows as the logarithm of that of samples.
const GROWTH: u64 = 64;

/// Numbers of the samples of a block: the first 64 have `block_length` each, further ones a 64th of those before them.
pub(crate) fn samples_of(block_length: u64, block: u64) -> Range<u64> {
    let mut start = block_length * block.min(GROWTH);
    for _ in GROWTH..block {
        start += start / GROWTH;
    }
    start..start + if block < GROWTH { block_length } else { start / GROWTH }
}

/// Smallest number of blocks with at least so many samples.
pub(crate) fn blocks_for(block_length: u64, n_samples: u64) -> u64 {
    if n_samples <= block_length * GROWTH {
        return n_samples.div_ceil(block_length);
    }
    let (mut end, mut n_blocks) = (block_length * GROWTH, GROWTH);
    while end < n_samples {
        end += end / GROWTH;
        n_blocks += 1;
    }
    n_blocks
}
