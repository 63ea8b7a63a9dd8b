//! Ranks without MPI: a single process, and threads that act as ranks.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::error::TransportError;
use crate::ranks::Ranks;

/// A single rank without communication.
#[derive(Debug, Clone, Copy, Default)]
pub struct Alone;

impl Ranks for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn n_ranks(&self) -> usize {
        1
    }

    fn send(&self, to: usize, _: &[u8]) -> Result<(), TransportError> {
        Err(TransportError::Gone { rank: to })
    }

    fn receive(&self, patience: Duration) -> Result<Option<(usize, Vec<u8>)>, TransportError> {
        std::thread::sleep(patience);
        Ok(None)
    }
}

/// A message with the rank that sent it.
type Letter = (usize, Vec<u8>);

/// One of several ranks that are threads of a process: the same job without MPI, for tests and trials.
///
/// Rank 0 can reach all others, and they can reach rank 0; a job needs no other connections. A rank detects when its
/// partner has exited.
#[derive(Debug)]
pub struct ThreadRank {
    rank: usize,
    inbox: Mutex<Receiver<Letter>>,
    /// By rank; `None` without a connection.
    others: Vec<Option<Sender<Letter>>>,
}

impl ThreadRank {
    /// All ranks of a job, one for each thread.
    #[must_use]
    pub fn all(n_ranks: usize) -> Vec<Self> {
        let (senders, inboxes): (Vec<_>, Vec<_>) = (0..n_ranks).map(|_| channel()).unzip();
        let is_way = |from: usize, to: usize| (from == 0) != (to == 0);
        let others = |from: usize| {
            let way =
                |(to, sender): (usize, &Sender<Letter>)| is_way(from, to).then(|| sender.clone());
            senders.iter().enumerate().map(way).collect()
        };
        let rank = |(rank, inbox)| Self { rank, inbox: Mutex::new(inbox), others: others(rank) };
        inboxes.into_iter().enumerate().map(rank).collect()
    }
}

impl Ranks for ThreadRank {
    fn rank(&self) -> usize {
        self.rank
    }

    fn n_ranks(&self) -> usize {
        self.others.len()
    }

    fn send(&self, to: usize, message: &[u8]) -> Result<(), TransportError> {
        let gone = TransportError::Gone { rank: to };
        let sender = self.others.get(to).and_then(Option::as_ref).ok_or_else(|| gone.clone())?;
        sender.send((self.rank, message.to_vec())).map_err(|_| gone)
    }

    fn receive(&self, patience: Duration) -> Result<Option<Letter>, TransportError> {
        let inbox = self.inbox.lock().unwrap_or_else(PoisonError::into_inner);
        match inbox.recv_timeout(patience) {
            Ok(letter) => Ok(Some(letter)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            // The only thread: no other rank holds its address.
            Err(RecvTimeoutError::Disconnected) if self.others.len() == 1 => {
                std::thread::sleep(patience);
                Ok(None)
            }
            Err(RecvTimeoutError::Disconnected) => Err(TransportError::Gone { rank: self.rank }),
        }
    }
}
