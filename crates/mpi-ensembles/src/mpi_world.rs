//! Ranks of an MPI job, through rsmpi.

use std::fmt;
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::datatype::Equivalence;
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, Source};

use crate::error::TransportError;
use crate::ranks::Ranks;

/// Polling interval: a waiting rank leaves its processor to computing ranks.
const LOOK_EVERY: Duration = Duration::from_micros(200);

/// Tag of all messages.
const TAG: mpi::Tag = 0;

/// All ranks started by `mpirun`. Dropping it finalises MPI.
pub struct World {
    // Dropped before the universe that owns it.
    communicator: SimpleCommunicator,
    _universe: Universe,
}

impl World {
    /// Starts MPI: once in a process, on the thread that then communicates with the other ranks.
    ///
    /// # Errors
    /// [`TransportError::Started`] on a second call; [`TransportError::Threads`] for a library without thread support.
    pub fn start() -> Result<Self, TransportError> {
        let (universe, level) =
            mpi::initialize_with_threading(Threading::Funneled).ok_or(TransportError::Started)?;
        if level < Threading::Funneled {
            return Err(TransportError::Threads { found: format!("{level:?}") });
        }
        Ok(Self { communicator: universe.world(), _universe: universe })
    }

    /// Aborts the processes of all ranks with this exit code, whatever their state.
    pub fn abort(&self, code: i32) -> ! {
        self.communicator.abort(code)
    }
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rank, n_ranks) = (self.rank(), self.n_ranks());
        f.debug_struct("World").field("rank", &rank).field("n_ranks", &n_ranks).finish()
    }
}

impl Ranks for World {
    fn rank(&self) -> usize {
        usize::try_from(self.communicator.rank()).unwrap_or_default()
    }

    fn n_ranks(&self) -> usize {
        usize::try_from(self.communicator.size()).unwrap_or_default()
    }

    fn send(&self, to: usize, message: &[u8]) -> Result<(), TransportError> {
        let rank = i32::try_from(to).ok().filter(|rank| *rank < self.communicator.size());
        let Some(rank) = rank else { return Err(TransportError::Gone { rank: to }) };
        self.communicator.process_at_rank(rank).send_with_tag(message, TAG);
        Ok(())
    }

    fn receive(&self, patience: Duration) -> Result<Option<(usize, Vec<u8>)>, TransportError> {
        let start = Instant::now();
        loop {
            let any = self.communicator.any_process();
            if let Some((message, status)) = any.immediate_matched_probe_with_tag(TAG) {
                // Neither is negative in a message that MPI has received.
                let unsigned = |number: i32| usize::try_from(number).unwrap_or_default();
                let mut bytes = vec![0_u8; unsigned(status.count(u8::equivalent_datatype()))];
                message.matched_receive_into(&mut bytes[..]);
                return Ok(Some((unsigned(status.source_rank()), bytes)));
            }
            let left = patience.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Ok(None);
            }
            std::thread::sleep(left.min(LOOK_EVERY));
        }
    }
}
