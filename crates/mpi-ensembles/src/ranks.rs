//! What carries messages between ranks.

use std::fmt;
use std::time::Duration;

use crate::error::TransportError;

/// The ranks of a job, as one of them sees them: `0..n_ranks`, of which rank 0 hands out the work.
///
/// Messages between two ranks arrive whole, once, and in the order in which they were sent. What rank 0 sends is short (below 4 KiB but for
/// the answer to a foreign rank), and it sends to a rank only when that rank waits for it: a blocking send cannot wait for ever.
pub trait Ranks: fmt::Debug {
    /// The number of this rank.
    fn rank(&self) -> usize;

    /// How many there are.
    fn n_ranks(&self) -> usize;

    /// Sends a message to another rank.
    ///
    /// # Errors
    /// [`TransportError`] where that rank is gone.
    fn send(&self, to: usize, message: &[u8]) -> Result<(), TransportError>;

    /// The next message that came, with the rank that sent it; `None` if none comes within `patience`.
    ///
    /// # Errors
    /// [`TransportError`] where none can come any more.
    fn receive(&self, patience: Duration) -> Result<Option<(usize, Vec<u8>)>, TransportError>;
}
