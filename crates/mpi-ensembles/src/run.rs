//! Execution of a job on all ranks.

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
    /// Computes all blocks that the store does not hold.
    ///
    /// Every rank calls it with the same arguments. Only rank 0 uses `store` and `look`; the other ranks return `None`
    /// when no block is left.
    ///
    /// Rank 0 assigns one block at a time to each idle rank, in ascending order, so that blocks of unequal cost
    /// balance. It computes blocks too, on a separate thread, while the calling thread polls for messages. Ranks
    /// exchange complete results of blocks, never partial sums. `look` receives all results so far, by block, after
    /// each new result.
    ///
    /// # Errors
    /// [`JobError::NoBlocks`]; on rank 0 [`JobError::Block`] with rank and block if a block fails or panics,
    /// [`JobError::ForeignRank`], [`JobError::Store`].
    ///
    /// Blocks finished before the error are stored. Blocks in progress on other ranks are lost, and those ranks are
    /// not notified. End an MPI job by
    /// [`World::abort`](https://docs.rs/mpi-ensembles/latest/mpi_ensembles/struct.World.html#method.abort) (feature
    /// `mpi`).
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

/// The result of a block, or the text of its failure.
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
