//! An ensemble whose items any process may compute: in sequence, as a shard, on ranks, or merged from shards.

use std::ops::Range;
use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::inputs::Inputs;
use super::kind_run::Run;
use super::part::EnsemblePart;
use super::run_error::RunError;
use crate::clock::CpuClock;

/// An ensemble of items that do not depend on each other, such as blocks of paths.
pub struct Ensemble<'a, T> {
    /// Name of its items in progress messages and in a checkpoint.
    pub what: &'static str,
    /// Number of items that one process computes, or shards in several.
    pub n: u64,
    /// Number of items that the ranks of a job share.
    pub n_on_ranks: u64,
    /// Number of items that one process computes between two looks at the checkpoint.
    pub at_once: u64,
    /// Computes a range of items, given how many there are.
    pub compute: &'a (dyn Fn(Range<u64>, u64) -> Result<Vec<T>, RunError> + Sync),
    /// Formats the current estimate from the items so far.
    pub words: &'a dyn Fn(&[T]) -> String,
}

/// Computed items, in order.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Items<T> {
    /// The items.
    pub list: Vec<T>,
    /// CPU time that they took (s).
    pub cpu_seconds: f64,
}

/// The result of an ensemble on this process.
#[derive(Debug)]
pub enum Computed<T> {
    /// The whole ensemble.
    Here(T),
    /// The files of a shard, or none on a rank without the result.
    Elsewhere(Vec<PathBuf>),
}

impl<T> Computed<T> {
    /// Applies a function to the whole ensemble.
    pub fn map<U>(self, of: impl FnOnce(T) -> U) -> Computed<U> {
        match self {
            Self::Here(all) => Computed::Here(of(all)),
            Self::Elsewhere(files) => Computed::Elsewhere(files),
        }
    }
}

impl<T> std::fmt::Debug for Ensemble<'_, T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.n, self.what)
    }
}

impl<T> Items<T> {
    fn join(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self { list: Vec::new(), cpu_seconds: 0.0 };
        for part in parts {
            all.list.extend(part.list);
            all.cpu_seconds += part.cpu_seconds;
        }
        all
    }
}

impl Run<'_> {
    /// The parts of an ensemble in order: those of shards whose files are given, blocks computed by the ranks, or what this process
    /// computes by `here`, which is the whole or its shard. `words` formats the current estimate.
    ///
    /// # Errors
    /// Those of `block` and `here`; [`RunError::Shards`], [`RunError::Job`], [`RunError::Checkpoint`].
    pub fn parts<T: Serialize + DeserializeOwned + Send>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        n_blocks: u64,
        block: &(dyn Fn(u64) -> Result<T, RunError> + Sync),
        words: &dyn Fn(&mut dyn Iterator<Item = &T>) -> String,
        here: impl FnOnce() -> Result<T, RunError>,
    ) -> Result<Computed<Vec<T>>, RunError> {
        if let Some(shards) = self.shards(inputs)? {
            return Ok(Computed::Here(shards));
        }
        Ok(match (self.part(), self.ranks()) {
            (_, Some(ranks)) => {
                let parts = self.on_ranks(ranks, inputs, n_blocks, block, words)?;
                parts.map_or_else(|| Computed::Elsewhere(Vec::new()), Computed::Here)
            }
            (EnsemblePart::Shard(place), None) => {
                Computed::Elsewhere(vec![self.write_shard(inputs, *place, &here()?)?])
            }
            (EnsemblePart::Whole | EnsemblePart::Merged(_), None) => Computed::Here(vec![here()?]),
        })
    }

    /// Computes an ensemble, or the part of it that is asked for.
    ///
    /// # Errors
    /// Those of [`Run::parts`]; [`RunError::TooLong`], with what is done in the checkpoint.
    pub fn ensemble<T: Serialize + DeserializeOwned + Clone + Send>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        ensemble: &Ensemble<'_, T>,
    ) -> Result<Computed<Items<T>>, RunError> {
        let items = |range, n| {
            let clock = CpuClock::start();
            let list = (ensemble.compute)(range, n)?;
            Ok(Items { list, cpu_seconds: clock.seconds() })
        };
        let n = ensemble.n_on_ranks;
        let words = |parts: &mut dyn Iterator<Item = &Items<T>>| {
            let list: Vec<T> = parts.flat_map(|part| part.list.iter().cloned()).collect();
            (ensemble.words)(&list)
        };
        let block = |block| items(block..block + 1, n);
        let here = || self.in_sequence(inputs, ensemble, &items);
        Ok(self.parts(inputs, n, &block, &words, here)?.map(Items::join))
    }

    /// The items of this process, after those of the checkpoint of an earlier run.
    fn in_sequence<T: Serialize + DeserializeOwned>(
        &self,
        inputs: &Inputs<'_, impl Serialize>,
        ensemble: &Ensemble<'_, T>,
        items: &dyn Fn(Range<u64>, u64) -> Result<Items<T>, RunError>,
    ) -> Result<Items<T>, RunError> {
        let &Ensemble { what, n: n_items, at_once, words, .. } = ensemble;
        let checkpoint = self.checkpoint(inputs, &["/title"])?;
        let mut all = Items::join(checkpoint.part::<Items<T>>(what)?);
        let range = self.range(n_items);
        let n = range.end - range.start;
        let pace = self.pace(what);
        pace.at(all.list.len() as f64 / n as f64)?;
        loop {
            let done = all.list.len() as u64;
            self.progress.at((done, n), || words(&all.list));
            if done >= n {
                return Ok(all);
            }
            let first = range.start + done;
            let more = items(first..(first + at_once).min(range.end), n_items)?;
            all = Items::join([all, more]);
            let done = all.list.len() as u64;
            let allowed = pace.at(done as f64 / n as f64);
            if done == n || allowed.is_err() || checkpoint.is_due() {
                checkpoint.keep(what, &all)?;
            }
            allowed?;
        }
    }
}
