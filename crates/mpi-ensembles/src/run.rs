//! Runs a job on all ranks.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::coordinate::Coordinator;
use crate::error::JobError;
use crate::job::{Finished, Job};
use crate::ranks::Ranks;
use crate::store::Store;
use crate::work::work;

impl Job {
    /// Computes all blocks that the store does not have. Every rank calls it with the same arguments; `store` and `look` are used on rank 0
    /// alone, and the others return `None` when nothing is left to do.
    ///
    /// Rank 0 hands out a block at a time to whoever is free, in rising order, so that uneven blocks balance; it computes as well, on a
    /// thread of its own, while the thread that called looks for messages. What crosses ranks is whole results of blocks, never sums over
    /// some of them. `look` sees all results so far, by block, after each.
    ///
    /// # Errors
    /// [`JobError::NoBlocks`]; on rank 0 [`JobError::Block`] with rank and block where one fails or panics, [`JobError::ForeignRank`],
    /// [`JobError::Store`]: blocks that were done before are kept. What other ranks compute then is lost, and they hear nothing of it: end
    /// an MPI job by [`World::abort`](https://docs.rs/mpi-ensembles/latest/mpi_ensembles/struct.World.html#method.abort) (feature `mpi`).
    pub fn run<R, T, E>(
        &self,
        ranks: &R,
        compute: impl Fn(u64) -> Result<T, E> + Sync,
        store: &mut dyn Store<T>,
        look: &mut dyn FnMut(&BTreeMap<u64, T>),
    ) -> Result<Option<Finished<T>>, JobError>
    where
        R: Ranks + ?Sized,
        T: Serialize + DeserializeOwned + Send,
        E: Display,
    {
        if self.n_blocks == 0 {
            return Err(JobError::NoBlocks);
        }
        let attempt = |block: u64| attempt(&compute, block);
        if ranks.rank() == 0 {
            Coordinator::new(self, ranks, store, look)?.run(attempt).map(Some)
        } else {
            work(self, ranks, attempt).map(|()| None)
        }
    }
}

/// The result of a block, or what is to be said of its failure.
fn attempt<T, E: Display>(compute: &impl Fn(u64) -> Result<T, E>, block: u64) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(|| compute(block))) {
        Ok(Ok(part)) => Ok(part),
        Ok(Err(error)) => Err(error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(ToString::to_string);
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
            Err(format!("panicked: {}", text.unwrap_or_default()))
        }
    }
}
