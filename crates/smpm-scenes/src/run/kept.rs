//! Runs of a study in the checkpoint of a scene.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::{Mutex, MutexGuard, PoisonError};

use scene_runs::checkpoint::Checkpoint;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Limit, Pace, Run, RunError, TooLong};
use serde::{Deserialize, Serialize};
use smpm::uncertainty::{Keep, SavedRun};

/// Content of a checkpoint for a run.
#[derive(Debug, Serialize, Deserialize)]
struct KeptRun {
    standing: SavedRun,
    /// CPU time of all runs of the scene so far, in all processes (s).
    cpu_seconds: f64,
}

/// The checkpoint of a scene, if any, as the storage of its study. The name of a part is that of the run.
#[derive(Debug)]
pub(super) struct KeptRuns<'a> {
    pub(super) checkpoint: Option<&'a Checkpoint>,
    clock: CpuClock,
    limit: Limit<'a>,
    state: Mutex<State<'a>>,
}

#[derive(Debug, Default)]
struct State<'a> {
    /// CPU time of earlier processes (s).
    past_seconds: f64,
    /// Error that was passed to the study as text.
    failure: Option<RunError>,
    /// The pace of each run.
    paces: BTreeMap<String, Pace<'a>>,
    /// No run goes on once one would take too long.
    too_long: Option<TooLong>,
}

impl<'a> KeptRuns<'a> {
    pub(super) fn new(checkpoint: Option<&'a Checkpoint>, run: &'a Run<'_>) -> Self {
        let (clock, limit) = (CpuClock::start(), run.limit());
        Self { checkpoint, clock, limit, state: Mutex::default() }
    }

    /// CPU time of all processes so far (s).
    pub(super) fn cpu_seconds(&self) -> f64 {
        let state = self.state();
        state.past_seconds + self.clock.seconds()
    }

    /// Why a run was not kept, or is not to go on.
    pub(super) fn into_failure(self) -> Option<RunError> {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).failure
    }

    /// Stores an error and returns its text.
    fn failed(&self, failure: impl Into<RunError>) -> Box<dyn Error + Send + Sync> {
        let failure = failure.into();
        let words = failure.to_string();
        self.state().failure = Some(failure);
        words.into()
    }

    fn state(&self) -> MutexGuard<'_, State<'a>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Keep for KeptRuns<'_> {
    fn load(&self, run: &str) -> Result<Option<SavedRun>, Box<dyn Error + Send + Sync>> {
        let kept = self.checkpoint.map_or(Ok(None), |it| it.part::<KeptRun>(run));
        let Some(KeptRun { standing, cpu_seconds }) = kept.map_err(|error| self.failed(error))?
        else {
            return Ok(None);
        };
        let mut state = self.state();
        state.past_seconds = state.past_seconds.max(cpu_seconds);
        Ok(Some(standing))
    }

    fn is_due(&self, run: &str, done: f64) -> bool {
        let Some(checkpoint) = self.checkpoint else { return false };
        let mut state = self.state();
        if !state.paces.contains_key(run) {
            state.paces.insert(run.to_owned(), self.limit.pace("one run of the bodies"));
        }
        let refused = state.paces.get(run).and_then(|pace| pace.at(done).err());
        state.too_long = state.too_long.take().or(refused);
        state.too_long.is_some() || checkpoint.is_due()
    }

    fn keep(&self, run: &str, standing: SavedRun) -> Result<(), Box<dyn Error + Send + Sync>> {
        let Some(checkpoint) = self.checkpoint else { return Ok(()) };
        let kept = KeptRun { standing, cpu_seconds: self.cpu_seconds() };
        let too_long = self.state().too_long.clone();
        match too_long {
            None => checkpoint.keep_if_due(run, &kept).map_err(|error| self.failed(error)),
            Some(too_long) => {
                checkpoint.keep(run, &kept).map_err(|error| self.failed(error))?;
                Err(self.failed(too_long))
            }
        }
    }
}
