//! Work budget of a run.

/// The run exceeds its work limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("work limit reached: {asked} steps asked for, the limit is {limit}")]
pub(crate) struct WorkLimit {
    /// Total requested work.
    pub(crate) asked: u64,
    /// Work limit.
    pub(crate) limit: u64,
}

/// Work budget of one run, in steps or in another unit of its map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Work {
    spent: u64,
    limit: u64,
}

impl Work {
    /// A budget with no work spent.
    pub(crate) const fn new(limit: u64) -> Self {
        Self { spent: 0, limit }
    }

    /// Work done so far.
    pub(crate) const fn spent(&self) -> u64 {
        self.spent
    }

    /// Requests more work before it is done.
    pub(crate) fn spend(&mut self, steps: u64) -> Result<(), WorkLimit> {
        let asked = self.spent.saturating_add(steps);
        if asked > self.limit {
            return Err(WorkLimit { asked, limit: self.limit });
        }
        self.spent = asked;
        Ok(())
    }
}
