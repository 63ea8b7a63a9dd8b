//! Shards of an ensemble, computed separately; their merge is bitwise identical to the whole.

use crate::blocks::{BLOCK_LENGTH, map_blocks, reduce_in_tree};
use crate::ensembles::ensemble::{Block, Ensemble, Failing, Study, estimates, merge_tallies};
use crate::ensembles::tally::Tally;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::integrator::Integrator;
use crate::law::InitialDistribution;

/// Identity common to all shards of a study. Its name represents what cannot be compared: system and functions.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Identity {
    name: String,
    version: String,
    seed: u64,
    n_paths: u64,
    dt: f64,
    times: Vec<f64>,
    path_steps: u128,
    observables: Vec<String>,
    n_shards: u64,
}

/// Part `k` of `n` of a study: complete blocks of paths with their tallies.
///
/// With the feature `serde` it can be serialised. The format must preserve all bits of a number (`float_roundtrip` in
/// serde_json).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct ShardRecord {
    identity: Identity,
    shard: u64,
    /// SIMD level of the computation: reported, not compared.
    level: String,
    blocks: Vec<BlockRecord>,
}

#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct BlockRecord {
    tallies: Vec<Tally>,
    n_failed: u64,
    first_failure: Option<FailedPath>,
}

/// A failed path and its error.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FailedPath {
    /// Its realisation.
    pub realisation: u64,
    /// Error text with step, time and value.
    pub message: String,
}

/// Results of all paths of a study, including failed ones.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Outcome {
    /// Number of paths.
    pub n_paths: u64,
    /// Number of failed paths.
    pub n_failed: u64,
    /// The failed path with the lowest number.
    pub first_failure: Option<FailedPath>,
    times: Vec<f64>,
    path_steps: u128,
    n_observables: usize,
    tallies: Vec<Tally>,
}

impl Outcome {
    /// Fraction of failed paths, as an estimate of the failure probability.
    ///
    /// # Errors
    /// None in practice: there are at least two paths.
    pub fn failure_probability(&self) -> Result<Estimate, Error> {
        Estimate::probability(self.n_failed, self.n_paths)
    }

    /// The estimates over all paths.
    ///
    /// # Errors
    /// [`Error::PathsFailed`] if any path failed, because the remaining ones are no sample of the distribution.
    pub fn ensemble(&self) -> Result<Ensemble, Error> {
        if let Some(first) = &self.first_failure {
            return Err(Error::PathsFailed {
                n_failed: self.n_failed,
                n_paths: self.n_paths,
                realisation: first.realisation,
                message: first.message.clone(),
            });
        }
        Ok(Ensemble {
            times: self.times.clone(),
            estimates: estimates(&self.tallies, self.n_observables)?,
            n_paths: self.n_paths,
            path_steps: self.path_steps,
        })
    }
}

impl<S, I, L, const D: usize> Study<'_, S, I, L, D>
where
    S: Sync + ?Sized,
    L: InitialDistribution<D> + ?Sized,
{
    /// Simulates all paths and counts failed ones.
    ///
    /// # Errors
    /// Errors of the configuration, as in [`simulate`](crate::simulate).
    pub fn run<const M: usize>(&self) -> Result<Outcome, Error>
    where
        I: Integrator<S, D, M>,
    {
        merge(&[self.shard::<M>(0, 1)?])
    }

    /// Simulates part `shard` of `n_shards`, from 0: the blocks from `shard B / n_shards` on, of `B` in all.
    ///
    /// # Errors
    /// Those of [`run`](Self::run); [`Error::NoSuchShard`].
    pub fn shard<const M: usize>(&self, shard: u64, n_shards: u64) -> Result<ShardRecord, Error>
    where
        I: Integrator<S, D, M>,
    {
        if shard >= n_shards {
            return Err(Error::NoSuchShard { shard, n_shards });
        }
        let legs = self.check()?;
        let config = self.config;
        let range = block_range(config.n_paths, shard, n_shards);
        let blocks = map_blocks(config.n_paths, range, |ids| {
            BlockRecord::from(self.block::<M>(&legs, ids, Failing::Counts))
        });
        let steps: u64 = legs.iter().map(|leg| leg.n_steps).sum();
        let identity = Identity {
            name: self.name.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            seed: config.seed,
            n_paths: config.n_paths,
            dt: config.dt,
            times: config.times.clone(),
            path_steps: u128::from(steps) * u128::from(config.n_paths),
            observables: self.observables.iter().map(|o| format!("{o:?}")).collect(),
            n_shards,
        };
        Ok(ShardRecord { identity, shard, level: self.level.name().into(), blocks })
    }
}

impl From<Block> for BlockRecord {
    fn from(block: Block) -> Self {
        let Block { tallies, n_failed, first_failure } = block;
        let first_failure = first_failure
            .map(|(realisation, error)| FailedPath { realisation, message: error.to_string() });
        Self { tallies, n_failed, first_failure }
    }
}

/// The blocks of a shard.
fn block_range(n_paths: u64, shard: u64, n_shards: u64) -> std::ops::Range<u64> {
    let n_blocks = u128::from(n_paths.div_ceil(BLOCK_LENGTH));
    let bound =
        |k: u64| u64::try_from(n_blocks * u128::from(k) / u128::from(n_shards)).unwrap_or(u64::MAX);
    bound(shard)..bound(shard + 1)
}

/// Merges all shards of a study, in any order; bitwise identical to one run.
///
/// # Errors
/// [`Error::TooFew`] for no shard; [`Error::ForeignShard`] with the first difference from the first record;
/// [`Error::DoubledShard`], [`Error::MissingShard`]; [`Error::BrokenShard`] for a record with the wrong number of
/// blocks, [`Error::BrokenBlock`] for one with an impossible block.
pub fn merge(records: &[ShardRecord]) -> Result<Outcome, Error> {
    let ordered = ordered(records)?;
    let n_shards = ordered[0].identity.n_shards;
    let present = |shard: u64| ordered.binary_search_by_key(&shard, |r| r.shard).is_ok();
    if let Some(shard) = (0..n_shards).find(|&shard| !present(shard)) {
        return Err(Error::MissingShard { shard, n_shards });
    }
    joined(&ordered)
}

/// Merges the available shards of a study while others still run.
///
/// The paths of the result, and its failed paths, are those of these shards.
///
/// # Errors
/// Those of [`merge`], except for missing shards.
pub fn merge_so_far(records: &[ShardRecord]) -> Result<Outcome, Error> {
    joined(&ordered(records)?)
}

/// Records of one study by number; at least one, without duplicates.
fn ordered(records: &[ShardRecord]) -> Result<Vec<&ShardRecord>, Error> {
    let Some(first) = records.first() else {
        return Err(Error::TooFew { quantity: "shards", value: 0, limit: 1 });
    };
    for record in records {
        first.identity.require_same(&record.identity, record.shard)?;
    }
    let mut ordered: Vec<_> = records.iter().collect();
    ordered.sort_by_key(|record| record.shard);
    match ordered.windows(2).find(|pair| pair[0].shard == pair[1].shard) {
        Some(pair) => Err(Error::DoubledShard { shard: pair[0].shard }),
        None => Ok(ordered),
    }
}

fn joined(ordered: &[&ShardRecord]) -> Result<Outcome, Error> {
    let identity = &ordered[0].identity;
    ordered.iter().try_for_each(|record| record.require_whole())?;
    let blocks: Vec<&BlockRecord> = ordered.iter().flat_map(|record| &record.blocks).collect();
    if let Some(first) = blocks.first() {
        ordered.iter().try_for_each(|record| record.require_like(first))?;
    }
    let tallies =
        reduce_in_tree(&blocks, &|block| block.tallies.clone(), &merge_tallies).unwrap_or_default();
    let n_paths = ordered.iter().map(|record| record.n_paths()).sum();
    // A product of the steps of one path and the number of paths.
    let steps = identity.path_steps / u128::from(identity.n_paths.max(1));
    Ok(Outcome {
        n_paths,
        n_failed: blocks.iter().map(|block| block.n_failed).sum(),
        first_failure: blocks.iter().find_map(|block| block.first_failure.clone()),
        times: identity.times.clone(),
        path_steps: steps * u128::from(n_paths),
        n_observables: identity.observables.len(),
        tallies,
    })
}

impl ShardRecord {
    /// Its number, and the number of shards.
    #[must_use]
    pub fn place(&self) -> (u64, u64) {
        (self.shard, self.identity.n_shards)
    }

    /// Number of paths in its blocks.
    fn n_paths(&self) -> u64 {
        let Identity { n_paths, n_shards, .. } = self.identity;
        let blocks = block_range(n_paths, self.shard, n_shards);
        let end = blocks.end.saturating_mul(BLOCK_LENGTH).min(n_paths);
        end.saturating_sub(blocks.start.saturating_mul(BLOCK_LENGTH))
    }

    /// Rejects blocks that cannot be merged with the first.
    fn require_like(&self, first: &BlockRecord) -> Result<(), Error> {
        let is_like = |block: &BlockRecord| {
            let mut pairs = block.tallies.iter().zip(&first.tallies);
            block.n_failed <= BLOCK_LENGTH && pairs.all(|(a, b)| a.is_of(BLOCK_LENGTH, b))
        };
        match self.blocks.iter().position(|block| !is_like(block)) {
            Some(block) => Err(Error::BrokenBlock { shard: self.shard, block }),
            None => Ok(()),
        }
    }

    fn require_whole(&self) -> Result<(), Error> {
        let Identity { n_paths, n_shards, ref times, ref observables, .. } = self.identity;
        if self.shard >= n_shards {
            return Err(Error::NoSuchShard { shard: self.shard, n_shards });
        }
        let range = block_range(n_paths, self.shard, n_shards);
        let (n_blocks, expected) = (self.blocks.len() as u64, range.end - range.start);
        let n_tallies = times.len().saturating_mul(observables.len());
        let is_whole = self.blocks.iter().all(|block| block.tallies.len() == n_tallies);
        if n_blocks == expected && is_whole {
            Ok(())
        } else {
            Err(Error::BrokenShard { shard: self.shard, n_blocks, expected })
        }
    }
}

impl Identity {
    fn require_same(&self, other: &Self, shard: u64) -> Result<(), Error> {
        let fields = [
            ("name", self.name.clone(), other.name.clone()),
            ("version", self.version.clone(), other.version.clone()),
            ("seed", self.seed.to_string(), other.seed.to_string()),
            ("n_paths", self.n_paths.to_string(), other.n_paths.to_string()),
            ("dt", self.dt.to_string(), other.dt.to_string()),
            ("times", format!("{:?}", self.times), format!("{:?}", other.times)),
            ("path_steps", self.path_steps.to_string(), other.path_steps.to_string()),
            ("observables", self.observables.join(" "), other.observables.join(" ")),
            ("n_shards", self.n_shards.to_string(), other.n_shards.to_string()),
        ];
        match fields.into_iter().find(|(_, expected, value)| expected != value) {
            Some((field, expected, value)) => {
                Err(Error::ForeignShard { shard, field, value, expected })
            }
            None => Ok(()),
        }
    }
}
