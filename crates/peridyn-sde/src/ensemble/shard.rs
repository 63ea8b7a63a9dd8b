//! Parts of an ensemble that run apart.

use super::crack_run::CrackRun;
use super::study::CrackStudy;
use crate::error::Error;
use crate::real::Real;

/// Part of an ensemble: the realisations from `shard n/shards` on.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CrackShard {
    /// Which part, from 0 on, and of how many.
    pub place: (u64, u64),
    /// Of all parts together.
    pub n_realisations: u64,
    /// The seed of the noise.
    pub seed: u64,
    /// The precision of its numbers.
    pub precision: String,
    /// What became of its realisations.
    pub run: CrackRun,
}

impl CrackStudy<'_> {
    /// Runs part `shard` of `n_shards` of an ensemble.
    ///
    /// # Errors
    /// As [`CrackStudy::run`]; [`Error::NoSuchShard`].
    pub fn shard<T: Real, const L: usize>(
        &self,
        n_realisations: u64,
        (shard, n_shards): (u64, u64),
        keep: &[u64],
    ) -> Result<CrackShard, Error> {
        if shard >= n_shards {
            return Err(Error::NoSuchShard { shard, n_shards });
        }
        let bound = |k: u64| n_realisations / n_shards * k + (n_realisations % n_shards).min(k);
        let run = self.run::<T, L>(bound(shard)..bound(shard + 1), keep)?;
        Ok(CrackShard {
            place: (shard, n_shards),
            n_realisations,
            seed: self.noise().seed(),
            precision: T::NAME.to_owned(),
            run,
        })
    }
}

/// Joins all shards of an ensemble, given in any order: the bits are those of one run.
///
/// # Errors
/// [`Error::TooFew`] for no shard, [`Error::ForeignShard`] for one of another ensemble; [`Error::Doubled`] and [`Error::Missing`] for
/// a realisation that is there twice or not at all, [`Error::NoSuchRealisation`] for one beyond the last; those of
/// [`CrackRun::append`].
pub fn merge_shards(mut shards: Vec<CrackShard>) -> Result<CrackRun, Error> {
    shards.sort_by_key(|shard| shard.place);
    let mut shards = shards.into_iter();
    let Some(first) = shards.next() else {
        return Err(Error::TooFew { name: "shards", value: 0, limit: 1 });
    };
    let same = |shard: &CrackShard| {
        (shard.place.1, shard.n_realisations, shard.seed, &shard.precision)
            == (first.place.1, first.n_realisations, first.seed, &first.precision)
    };
    let mut whole = first.run.clone();
    for shard in shards {
        if !same(&shard) {
            return Err(Error::ForeignShard { shard: shard.place.0 });
        }
        whole.append(shard.run)?;
    }
    let n_realisations = first.n_realisations;
    for (expected, record) in (0..).zip(&whole.records) {
        let realisation = record.realisation;
        if realisation < expected {
            return Err(Error::Doubled { realisation });
        }
        if realisation >= n_realisations {
            return Err(Error::NoSuchRealisation { realisation, limit: n_realisations });
        }
        if realisation > expected {
            return Err(Error::Missing { realisation: expected, n_realisations });
        }
    }
    let found = whole.records.len() as u64;
    if found < n_realisations {
        return Err(Error::Missing { realisation: found, n_realisations });
    }
    Ok(whole)
}
