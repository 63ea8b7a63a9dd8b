//! Storage of finished blocks on rank 0.

use std::error::Error;

/// Stores the results of blocks so that an interrupted job can resume. Only rank 0 has one.
///
/// This crate accesses no files: a store that writes files chooses their names, and rejects files of another ensemble
/// by name.
pub trait Store<T> {
    /// Loads the result of a block, if it was stored.
    ///
    /// # Errors
    /// If the stored data cannot be used; the job ends.
    fn load(&mut self, block: u64) -> Result<Option<T>, Box<dyn Error + Send + Sync>>;

    /// Stores the result of a block.
    ///
    /// # Errors
    /// If the result cannot be stored; the job ends.
    fn keep(&mut self, block: u64, part: &T) -> Result<(), Box<dyn Error + Send + Sync>>;
}

/// A store that keeps nothing after the job.
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
