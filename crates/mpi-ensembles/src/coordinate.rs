//! Rank 0: distributes blocks, collects results, and computes blocks as well.

use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;

use crate::error::{JobError, TransportError};
use crate::job::{Finished, Job};
use crate::message::Message;
use crate::ranks::Ranks;
use crate::report::{BlockReport, Report};
use crate::store::Store;

/// Polling interval for messages of other ranks.
const LOOK_EVERY: Duration = Duration::from_millis(1);
/// Polling interval without other ranks.
const ALONE: Duration = Duration::from_secs(1);

/// State of a rank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seat {
    /// It has sent no message yet.
    Silent,
    /// It computes this block.
    Computes(u64),
    /// It was notified that no block is left.
    Ended,
}

/// A result of rank 0: block, result, seconds.
type Own<T> = (u64, Result<T, String>, f64);

/// Rank 0.
pub(crate) struct Coordinator<'a, R: ?Sized, T> {
    job: &'a Job,
    ranks: &'a R,
    store: &'a mut dyn Store<T>,
    look: &'a mut dyn FnMut(&BTreeMap<u64, T>),
    /// Results by block.
    parts: BTreeMap<u64, T>,
    /// Unassigned blocks, in ascending order.
    left: VecDeque<u64>,
    seats: Vec<Seat>,
    report: Report,
    start: Instant,
}

impl<'a, R: Ranks + ?Sized, T: DeserializeOwned + Send> Coordinator<'a, R, T> {
    /// Loads the results that the store holds.
    ///
    /// # Errors
    /// [`JobError::Store`].
    pub(crate) fn new(
        job: &'a Job,
        ranks: &'a R,
        store: &'a mut dyn Store<T>,
        look: &'a mut dyn FnMut(&BTreeMap<u64, T>),
    ) -> Result<Self, JobError> {
        let (start, mut parts, mut left) = (Instant::now(), BTreeMap::new(), VecDeque::new());
        for block in 0..job.n_blocks {
            let known = store.load(block).map_err(|source| JobError::Store {
                block,
                what: "read",
                source,
            })?;
            match known {
                Some(part) => drop(parts.insert(block, part)),
                None => left.push_back(block),
            }
        }
        let n_ranks = ranks.n_ranks();
        let report = Report { n_ranks, n_known: parts.len() as u64, ..Report::default() };
        let seats = vec![Seat::Silent; n_ranks];
        Ok(Self { job, ranks, store, look, parts, left, seats, report, start })
    }

    /// Runs until every block has its result.
    pub(crate) fn run(
        mut self,
        attempt: impl Fn(u64) -> Result<T, String> + Sync,
    ) -> Result<Finished<T>, JobError> {
        let (orders, own_orders) = channel::<u64>();
        let (own_results, results) = channel::<Own<T>>();
        let attempt = &attempt;
        thread::scope(|scope| {
            let compute = move || {
                for block in own_orders {
                    let start = Instant::now();
                    let result = attempt(block);
                    if own_results.send((block, result, start.elapsed().as_secs_f64())).is_err() {
                        break;
                    }
                }
            };
            let thread = thread::Builder::new().name("blocks of rank 0".to_owned());
            thread.spawn_scoped(scope, compute).map_err(JobError::Thread)?;
            let served = self.serve(&orders, &results);
            // The thread ends after its last block.
            drop(orders);
            served
        })?;
        self.report.seconds = self.start.elapsed().as_secs_f64();
        Ok(Finished { parts: self.parts.into_values().collect(), report: self.report })
    }

    fn serve(&mut self, orders: &Sender<u64>, results: &Receiver<Own<T>>) -> Result<(), JobError> {
        let patience = if self.seats.len() == 1 { ALONE } else { LOOK_EVERY };
        self.seats[0] = self.order_own(orders);
        while self.seats.iter().any(|seat| *seat != Seat::Ended) {
            match results.recv_timeout(patience) {
                Ok((block, result, seconds)) => {
                    let failed = |message| JobError::Block { rank: 0, block, message };
                    let (part, came) = (result.map_err(failed)?, Instant::now());
                    // The thread takes the next block while its result is processed.
                    self.seats[0] = self.order_own(orders);
                    let report = BlockReport { block, rank: 0, seconds, bytes: 0, taking: 0.0 };
                    self.accept(report, part, came)?;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(TransportError::Gone { rank: 0 }.into());
                }
            }
            // Ranks that were notified of the end may have exited.
            while self.seats[1..].iter().any(|seat| *seat != Seat::Ended)
                && let Some((rank, bytes)) = self.ranks.receive(Duration::ZERO)?
            {
                self.hear(rank, Message::of(rank, &bytes)?)?;
            }
        }
        Ok(())
    }

    /// Sends the next block to the computing thread of rank 0.
    fn order_own(&mut self, orders: &Sender<u64>) -> Seat {
        let next = self.left.pop_front();
        match next.filter(|block| orders.send(*block).is_ok()) {
            Some(block) => Seat::Computes(block),
            None => Seat::Ended,
        }
    }

    fn hear(&mut self, rank: usize, message: Message) -> Result<(), JobError> {
        let seat = self.seats[rank];
        match (seat, message) {
            (Seat::Silent, Message::Ready { n_blocks, identity }) => {
                self.check(rank, n_blocks, &identity)?;
                self.order(rank)
            }
            (Seat::Computes(expected), Message::Done { block, part, seconds })
                if block == expected =>
            {
                let (bytes, came) = (part.len(), Instant::now());
                self.order(rank)?;
                let part = postcard::from_bytes(&part)
                    .map_err(|source| JobError::Message { rank, source })?;
                let report = BlockReport { block, rank, seconds, bytes, taking: 0.0 };
                self.accept(report, part, came)
            }
            (Seat::Computes(_), Message::Failed { block, message }) => {
                Err(JobError::Block { rank, block, message })
            }
            (Seat::Silent, other) => Err(other.out_of_turn(rank, "`ready`")),
            (Seat::Computes(_), other) => Err(other.out_of_turn(rank, "the result of its block")),
            (Seat::Ended, other) => Err(other.out_of_turn(rank, "nothing")),
        }
    }

    /// Rejects a rank of another job and notifies it.
    fn check(
        &self,
        rank: usize,
        n_blocks: u64,
        identity: &[(String, String)],
    ) -> Result<(), JobError> {
        let fields = |n_blocks: u64, identity: &[(String, String)]| {
            let number = ("number of blocks".to_owned(), n_blocks.to_string());
            identity.iter().cloned().chain([number]).collect::<Vec<_>>()
        };
        let here = fields(self.job.n_blocks, &self.job.identity);
        let there = fields(n_blocks, identity);
        let value = |fields: &[(String, String)], name: &str| {
            let field = fields.iter().find(|(known, _)| known == name);
            field.map_or_else(|| "absent".to_owned(), |(_, value)| value.clone())
        };
        // In the order of the job's fields: a field that explains the others comes first.
        for (name, _) in here.iter().chain(&there) {
            let (expected, found) = (value(&here, name), value(&there, name));
            if found != expected {
                let (f, e) = (found.clone(), expected.clone());
                let message = Message::Foreign { field: name.clone(), found: f, expected: e };
                self.tell(rank, &message)?;
                let field = name.clone();
                return Err(JobError::ForeignRank { rank, field, found, expected });
            }
        }
        Ok(())
    }

    /// Sends a rank its next block, or the end of the job.
    fn order(&mut self, rank: usize) -> Result<(), JobError> {
        let next = self.left.pop_front();
        let (seat, message) = match next {
            Some(block) => (Seat::Computes(block), Message::Compute { block }),
            None => (Seat::Ended, Message::End),
        };
        self.seats[rank] = seat;
        self.tell(rank, &message)
    }

    fn tell(&self, rank: usize, message: &Message) -> Result<(), JobError> {
        let bytes = message.to_bytes().map_err(|source| JobError::Message { rank, source })?;
        Ok(self.ranks.send(rank, &bytes)?)
    }

    /// Stores a result received at the given time.
    fn accept(&mut self, report: BlockReport, part: T, came: Instant) -> Result<(), JobError> {
        let block = report.block;
        self.store.keep(block, &part).map_err(|source| JobError::Store {
            block,
            what: "kept",
            source,
        })?;
        self.parts.insert(block, part);
        (self.look)(&self.parts);
        self.report.blocks.push(BlockReport { taking: came.elapsed().as_secs_f64(), ..report });
        Ok(())
    }
}
