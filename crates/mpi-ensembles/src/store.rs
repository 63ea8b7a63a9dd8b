//! Where rank 0 keeps the blocks that are done.

use std::error::Error;

/// Keeps the results of blocks, so that a job that was killed goes on from them. Rank 0 alone has one.
///
/// The crate touches no files: a store that writes them decides their names, and refuses those of another ensemble by name.
pub trait Store<T> {
    /// The result of a block from before, if it was kept.
    ///
    /// # Errors
    /// Where something was kept that cannot be taken: it ends the job.
    fn load(&mut self, block: u64) -> Result<Option<T>, Box<dyn Error + Send + Sync>>;

    /// Keeps the result of a block.
    ///
    /// # Errors
    /// Where it cannot be kept: it ends the job.
    fn keep(&mut self, block: u64, part: &T) -> Result<(), Box<dyn Error + Send + Sync>>;
}

/// Keeps nothing beyond the job.
#[derive(Debug, Clone, Copy, Default)]
pub struct InMemory;

impl<T> Store<T> for InMemory {
    fn load(&mut self, _: u64) -> Result<Option<T>, Box<dyn Error + Send + Sync>> {
        Ok(None)
    }

    fn keep(&mut self, _: u64, _: &T) -> Result<(), Box<dyn Error + Send + Sync>> {
        Ok(())
    }
}
