//! How long a part of a run will take, and whether it may.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::progress::Progress;
use crate::interrupt;

/// Time after which the duration of a part is estimated.
const PATIENCE: Duration = Duration::from_secs(10);
/// The same as a part of the longest time that is allowed, where that is shorter.
const PATIENT_PART: u32 = 10;
/// Least expected duration that is worth a line.
const WORTH_A_LINE: Duration = Duration::from_secs(60);

/// A part of a run would take longer than allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
#[error(
    "{what}: {} % took {}, so the rest takes about {}; at most {} are allowed",
    result_figures::number::short(Some(100.0 * done)), words(*elapsed), words(*left), words(*longest)
)]
#[diagnostic(help(
    "make the scene smaller, or allow it by --yes or a larger --longest; what is done is kept for --resume"
))]
pub struct TooLong {
    /// The part of the run.
    pub what: &'static str,
    /// The fraction of it that is done.
    pub done: f64,
    /// What that took.
    pub elapsed: Duration,
    /// What the rest would take at this pace.
    pub left: Duration,
    /// The limit.
    pub longest: Duration,
}

/// What the parts of a run are held to, for all threads.
#[derive(Debug, Clone, Copy)]
pub struct Limit<'a> {
    pub(super) longest: Option<Duration>,
    pub(super) progress: &'a Progress,
}

/// Pace of a part of a run. Its duration is estimated once, from what ten seconds have done.
#[derive(Debug)]
pub struct Pace<'a> {
    what: &'static str,
    limit: Limit<'a>,
    state: Mutex<State>,
}

#[derive(Debug)]
enum State {
    NotBegun,
    /// Since then, with this fraction done.
    Measured(Instant, f64),
    Allowed,
    Refused(TooLong),
}

impl<'a> Limit<'a> {
    /// The pace of a part.
    pub const fn pace(self, what: &'static str) -> Pace<'a> {
        Pace { what, limit: self, state: Mutex::new(State::NotBegun) }
    }
}

impl Pace<'_> {
    /// Takes note of the fraction of the part that is done, at its beginning too.
    ///
    /// # Errors
    /// [`TooLong`], from then on always.
    pub fn at(&self, done: f64) -> Result<(), TooLong> {
        self.at_time(done, Instant::now())
    }

    /// Whether the part may go on.
    ///
    /// # Errors
    /// [`TooLong`].
    pub fn allowed(&self) -> Result<(), TooLong> {
        match &*self.state.lock().unwrap_or_else(PoisonError::into_inner) {
            State::Refused(too_long) => Err(too_long.clone()),
            State::NotBegun | State::Measured(..) | State::Allowed => Ok(()),
        }
    }

    /// Takes note of the fraction of a part without checkpoints that is done: false where it may not go on, or a signal has come.
    pub fn goes_on(&self, done: f64) -> bool {
        !interrupt::is_requested() && self.at(done).is_ok()
    }

    fn at_time(&self, done: f64, now: Instant) -> Result<(), TooLong> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match &*state {
            State::NotBegun => *state = State::Measured(now, done),
            State::Allowed => {}
            State::Refused(too_long) => return Err(too_long.clone()),
            State::Measured(start, from) => {
                let (elapsed, part) = (now.duration_since(*start), done - from);
                let longest = self.limit.longest;
                let patience = longest.map_or(PATIENCE, |it| PATIENCE.min(it / PATIENT_PART));
                if elapsed < patience || part <= 0.0 {
                    return Ok(());
                }
                *state = self.judged(part, elapsed, elapsed.as_secs_f64() * (1.0 - done) / part);
                if let State::Refused(too_long) = &*state {
                    return Err(too_long.clone());
                }
            }
        }
        Ok(())
    }

    /// The state once the seconds that are left are known.
    fn judged(&self, done: f64, elapsed: Duration, left: f64) -> State {
        let left = Duration::try_from_secs_f64(left.max(0.0)).unwrap_or(Duration::MAX);
        if let Some(longest) = self.limit.longest.filter(|&longest| left > longest) {
            return State::Refused(TooLong { what: self.what, done, elapsed, left, longest });
        }
        if left >= WORTH_A_LINE {
            self.limit.progress.stage(&format!("{}: about {} to go", self.what, words(left)));
        }
        State::Allowed
    }
}

/// A duration in the largest unit of which there is more than two.
fn words(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    let units = [("years", 31_557_600.0), ("days", 86_400.0), ("h", 3600.0), ("min", 60.0)];
    let (unit, length) =
        units.into_iter().find(|(_, length)| seconds > 2.0 * length).unwrap_or(("s", 1.0));
    format!("{} {unit}", result_figures::number::short(Some(seconds / length)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: Duration = Duration::from_secs(86_400);

    fn pace(longest: Option<Duration>, progress: &Progress) -> Pace<'_> {
        Limit { longest, progress }.pace("samples")
    }

    #[test]
    fn a_part_is_judged_once_by_what_ten_seconds_have_done() {
        let progress = Progress::silent();
        let start = Instant::now();
        let at = |pace: &Pace<'_>, done, seconds| {
            pace.at_time(done, start + Duration::from_secs(seconds))
        };
        // A resumed part begins in its midst.
        for from in [0.0, 0.5] {
            let it = pace(Some(DAY), &progress);
            at(&it, from, 0).unwrap();
            at(&it, from + 1e-6, 9).unwrap();
            at(&it, from, 11).unwrap();
            let refused = at(&it, from + 1e-5, 12).unwrap_err();
            assert!(refused.left > DAY && refused.left < 14 * DAY, "{refused}");
            assert_eq!(at(&it, 0.99, 13).unwrap_err(), refused);
        }
        let quick = pace(Some(DAY), &progress);
        at(&quick, 0.0, 0).unwrap();
        at(&quick, 0.1, 10).unwrap();
        // Once allowed, a part that becomes slower is not stopped.
        at(&quick, 0.100_001, 80_000).unwrap();
        let unlimited = pace(None, &progress);
        at(&unlimited, 0.0, 0).unwrap();
        at(&unlimited, 1e-12, 11).unwrap();
    }

    #[test]
    fn the_error_has_the_numbers() {
        let progress = Progress::silent();
        let it = pace(Some(DAY), &progress);
        let start = Instant::now();
        it.at_time(0.0, start).unwrap();
        let error = it.at_time(2e-5, start + Duration::from_secs(15)).unwrap_err();
        let text = error.to_string();
        let expected = "samples: 0.00200 % took 15 s, so the rest takes about 8.68 days; at most 24 h are allowed";
        assert_eq!(text, expected);
    }
}
