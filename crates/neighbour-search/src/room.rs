//! Limit on the entries of a list: points that coincide have as many pairs as the square of their number.

use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use crate::error::Error;
use crate::list::CHUNK;

/// Entries that any list may hold: 512 MiB.
const SMALL: usize = 1 << 27;

/// Neighbours of a point, on average over a thousand rows, that a larger list may hold.
const MOST_NEIGHBOURS: usize = 1 << 12;

/// Memory that all threads of a search have taken for their rows.
#[derive(Debug, Default)]
pub(crate) struct Room {
    entries: AtomicUsize,
    is_exceeded: AtomicBool,
}

impl Room {
    /// Takes memory for `more` entries of a chunk that then has `of_chunk`; `false` where the list may not hold them.
    #[cold]
    pub(crate) fn takes(&self, of_chunk: usize, more: usize) -> bool {
        let all = self.entries.fetch_add(more, Relaxed) + more;
        let is_within = all <= SMALL || of_chunk <= MOST_NEIGHBOURS * CHUNK;
        if !is_within {
            self.is_exceeded.store(true, Relaxed);
        }
        is_within
    }

    /// Whether a chunk of rows did not find room.
    pub(crate) fn is_exceeded(&self) -> bool {
        self.is_exceeded.load(Relaxed)
    }

    /// # Errors
    /// [`Error::TooManyNeighbours`] if a chunk of rows did not find room.
    pub(crate) fn check(&self, points: usize) -> Result<(), Error> {
        if !self.is_exceeded() {
            return Ok(());
        }
        Err(Error::TooManyNeighbours { points, entries: SMALL, neighbours: MOST_NEIGHBOURS })
    }
}
