//! Message transport between ranks.

use std::fmt;
use std::time::Duration;

use crate::error::TransportError;

/// The ranks `0..n_ranks` of a job as seen by one of them; rank 0 distributes the work.
///
/// Messages between two ranks arrive complete, once, and in the order of sending. Messages of rank 0 are short: below
/// 4 KiB, except the answer to a foreign rank. Rank 0 sends to a rank only when that rank waits for a message, so a
/// blocking send cannot deadlock.
pub trait Ranks: fmt::Debug {
    /// Number of this rank.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn n_ranks(&self) -> usize;

    /// Sends a message to another rank.
    ///
    /// # Errors
    /// [`TransportError`] if that rank has exited.
    fn send(&self, to: usize, message: &[u8]) -> Result<(), TransportError>;

    /// Returns the next message with the rank that sent it, or `None` if none arrives within `patience`.
    ///
    /// # Errors
    /// [`TransportError`] if no further message can arrive.
    fn receive(&self, patience: Duration) -> Result<Option<(usize, Vec<u8>)>, TransportError>;
}
