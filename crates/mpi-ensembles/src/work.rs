//! The loop of every rank except rank 0.

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::error::JobError;
use crate::job::Job;
use crate::message::Message;
use crate::ranks::Ranks;

/// Time limit of one wait for a message.
const PATIENCE: Duration = Duration::from_secs(1);

/// Computes the blocks that rank 0 assigns until none is left.
pub(crate) fn work<R: Ranks + ?Sized, T: Serialize>(
    job: &Job,
    ranks: &R,
    attempt: impl Fn(u64) -> Result<T, String>,
) -> Result<(), JobError> {
    let rank = ranks.rank();
    let tell = |block: u64, message: &Message| -> Result<(), JobError> {
        let bytes = message.to_bytes().map_err(|source| JobError::Encode { block, source })?;
        Ok(ranks.send(0, &bytes)?)
    };
    tell(0, &Message::Ready { n_blocks: job.n_blocks, identity: job.identity.clone() })?;
    loop {
        let Some((from, bytes)) = ranks.receive(PATIENCE)? else { continue };
        match Message::of(from, &bytes)? {
            Message::Compute { block } => {
                let start = Instant::now();
                let result = attempt(block);
                let seconds = start.elapsed().as_secs_f64();
                let answer = match result {
                    Ok(part) => {
                        let part = postcard::to_stdvec(&part)
                            .map_err(|source| JobError::Encode { block, source })?;
                        Message::Done { block, part, seconds }
                    }
                    Err(message) => Message::Failed { block, message },
                };
                tell(block, &answer)?;
            }
            Message::End => return Ok(()),
            Message::Foreign { field, found, expected } => {
                return Err(JobError::ForeignRank { rank, field, found, expected });
            }
            other => return Err(other.out_of_turn(from, "an order")),
        }
    }
}
