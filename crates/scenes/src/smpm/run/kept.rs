//! Runs of a study in the checkpoint of a scene.

use std::error::Error;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use smpm::uncertainty::{Keep, Standing};

use crate::checkpoint::{Checkpoint, CheckpointError};
use crate::clock::CpuClock;

/// Content of a checkpoint for a run.
#[derive(Debug, Serialize, Deserialize)]
struct KeptRun {
    standing: Standing,
    /// CPU time of all runs of the scene so far, in all processes (s).
    cpu_seconds: f64,
}

/// The checkpoint of a scene, if any, as the storage of its study. The name of a part is that of the run.
#[derive(Debug)]
pub(super) struct KeptRuns<'a> {
    pub(super) checkpoint: Option<&'a Checkpoint>,
    clock: CpuClock,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// CPU time of earlier processes (s).
    past_seconds: f64,
    /// Error that was passed to the study as text.
    failure: Option<CheckpointError>,
}

impl<'a> KeptRuns<'a> {
    pub(super) fn new(checkpoint: Option<&'a Checkpoint>) -> Self {
        Self { checkpoint, clock: CpuClock::start(), state: Mutex::default() }
    }

    /// CPU time of all processes so far (s).
    pub(super) fn cpu_seconds(&self) -> f64 {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.past_seconds + self.clock.seconds()
    }

    /// Error of the checkpoint.
    pub(super) fn into_failure(self) -> Option<CheckpointError> {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).failure
    }

    /// Stores an error and returns its text.
    fn failed(&self, failure: CheckpointError) -> Box<dyn Error + Send + Sync> {
        let words = failure.to_string();
        self.state.lock().unwrap_or_else(PoisonError::into_inner).failure = Some(failure);
        words.into()
    }
}

impl Keep for KeptRuns<'_> {
    fn load(&self, run: &str) -> Result<Option<Standing>, Box<dyn Error + Send + Sync>> {
        let kept = self.checkpoint.map_or(Ok(None), |it| it.part::<KeptRun>(run));
        let Some(KeptRun { standing, cpu_seconds }) = kept.map_err(|error| self.failed(error))?
        else {
            return Ok(None);
        };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.past_seconds = state.past_seconds.max(cpu_seconds);
        Ok(Some(standing))
    }

    fn is_due(&self) -> bool {
        self.checkpoint.is_some_and(Checkpoint::is_due)
    }

    fn keep(&self, run: &str, standing: Standing) -> Result<(), Box<dyn Error + Send + Sync>> {
        let Some(checkpoint) = self.checkpoint else { return Ok(()) };
        let kept = KeptRun { standing, cpu_seconds: self.cpu_seconds() };
        checkpoint.keep_if_due(run, &kept).map_err(|error| self.failed(error))
    }
}
