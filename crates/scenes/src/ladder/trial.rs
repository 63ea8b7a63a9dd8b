//! Trial runs of rungs.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::{Map, Value};

use super::{Answer, Ladder, Method, Rung};
use crate::causes::with_causes;
use crate::clock::CpuClock;
use crate::kind::{Options, Progress, SceneKind};
use crate::scene::SceneFile;

/// A trial run.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Index of its method in [`Ladder::methods`].
    pub method: usize,
    /// The rung.
    pub rung: Rung,
    /// Its outcome.
    pub outcome: Outcome,
}

/// Outcome of a trial.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// A result.
    Answered(Answer),
    /// The run ended in an error.
    Failed {
        /// Text of the error.
        reason: String,
        /// CPU time until then (s).
        cpu_seconds: f64,
    },
}

/// Limits of trials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest expected cost of a trial (CPU s); the first trial of each method always begins.
    pub budget: f64,
    /// Longest projected time of a part of a trial, beyond which the trial ends with an error; no limit if none.
    pub longest: Option<Duration>,
}

/// Error that prevents a trial.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum LadderError {
    /// No folder for the results of trials is available.
    #[error("no folder for trial runs")]
    Folder(#[source] std::io::Error),
    /// A result is missing or invalid JSON.
    #[error("the result of a trial run cannot be read: {}", .path.display())]
    Result {
        /// Path of the result.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// A result lacks a quantity of its scene kind.
    #[error("the result of a run has no number {what}: {}", .path.display())]
    Missing {
        /// Path of the result.
        path: PathBuf,
        /// Its keys, with a dot between them.
        what: &'static str,
    },
}

impl Trial {
    /// The result, if there is one.
    #[must_use]
    pub const fn answer(&self) -> Option<&Answer> {
        match &self.outcome {
            Outcome::Answered(answer) => Some(answer),
            Outcome::Failed { .. } => None,
        }
    }

    /// CPU time (s), whether it ended in a result or in an error.
    #[must_use]
    pub const fn cpu_seconds(&self) -> f64 {
        match &self.outcome {
            Outcome::Answered(Answer { cpu_seconds, .. }) | Outcome::Failed { cpu_seconds, .. } => {
                *cpu_seconds
            }
        }
    }
}

/// Runs a method at increasing sizes, each about three times as expensive as the last.
///
/// It stops when the next run would cost more than the budget, or after three failures in a row. `tell` is called before each run.
///
/// # Errors
/// [`LadderError`]; a run that ends in an error is an outcome.
pub fn climb(
    kind: &SceneKind,
    file: &SceneFile,
    ladder: &Ladder,
    method: usize,
    limits: Limits,
    mut tell: impl FnMut(&Method, &Rung),
) -> Result<Vec<Trial>, LadderError> {
    let climbed = &ladder.methods[method];
    let (mut trials, mut size, mut failures) = (Vec::<Trial>::new(), climbed.first, 0);
    while let Some(rung) = (climbed.rung)(size) {
        // Rounding can make two sizes equal.
        let is_new = trials.last().is_none_or(|last| last.rung.size < rung.size);
        size = rung.size.max(size) * climbed.growth.factor();
        if !is_new {
            continue;
        }
        tell(climbed, &rung);
        let outcome = try_scene(kind, file, &rung.trial, limits.longest)?;
        let trial = Trial { method, rung, outcome };
        let (cost, is_answered) = (trial.cpu_seconds(), trial.answer().is_some());
        trials.push(trial);
        failures = if is_answered { 0 } else { failures + 1 };
        if is_next_beyond(cost, limits.budget) || failures > MOST_FAILURES {
            break;
        }
    }
    Ok(trials)
}

/// Whether the rung after one of this cost is expected to exceed a budget.
#[must_use]
pub fn is_next_beyond(cost: f64, budget: f64) -> bool {
    cost * super::COST_FACTOR > budget
}

/// Consecutive failures that a method may have; one more ends its trials. A lattice can be too coarse, not too fine.
const MOST_FAILURES: u32 = 2;

/// Runs one rung.
///
/// # Errors
/// [`LadderError`]; a run that ends in an error is an outcome.
pub fn try_rung(
    kind: &SceneKind,
    file: &SceneFile,
    method: usize,
    rung: Rung,
) -> Result<Trial, LadderError> {
    let outcome = try_scene(kind, file, &rung.trial, None)?;
    Ok(Trial { method, rung, outcome })
}

/// CPU times (s) of a trial and of its repetitions, in increasing order; empty for a trial without result.
///
/// # Errors
/// [`LadderError`].
pub fn repeated_costs(
    kind: &SceneKind,
    file: &SceneFile,
    trial: &Trial,
    again: usize,
) -> Result<Vec<f64>, LadderError> {
    let Some(answer) = trial.answer() else { return Ok(Vec::new()) };
    let mut costs = vec![answer.cpu_seconds];
    for _ in 0..again {
        let outcome = try_scene(kind, file, &trial.rung.trial, None)?;
        if let Outcome::Answered(answer) = outcome {
            costs.push(answer.cpu_seconds);
        }
    }
    costs.sort_by(f64::total_cmp);
    Ok(costs)
}

/// Runs a scene derived from `file`; relative paths start from the folder of `file`. The run ends with an error if the projected time
/// of a part exceeds `longest`.
///
/// # Errors
/// [`LadderError`]; a run that ends in an error is an outcome.
pub fn try_scene(
    kind: &SceneKind,
    file: &SceneFile,
    scene: &Map<String, Value>,
    longest: Option<Duration>,
) -> Result<Outcome, LadderError> {
    let folder = tempfile::tempdir().map_err(LadderError::Folder)?;
    let scene = file.with_keys(Value::Object(scene.clone()));
    let options = Options { longest, ..Options::new(folder.path()).without_page() };
    let clock = CpuClock::start();
    Ok(match kind.run_file(&scene, &options, &Progress::silent()) {
        Ok(_) => Outcome::Answered(read_answer(kind, folder.path())?),
        Err(error) => Outcome::Failed { reason: with_causes(&error), cpu_seconds: clock.seconds() },
    })
}

/// Reads the result in a folder.
///
/// # Errors
/// [`LadderError::Result`], [`LadderError::Missing`].
pub fn read_answer(kind: &SceneKind, folder: &Path) -> Result<Answer, LadderError> {
    const COST: &str = "work.cpu_seconds";
    let path = folder.join("result.json");
    let to_error = |source| LadderError::Result { path: path.clone(), source };
    let text = std::fs::read_to_string(&path).map_err(to_error)?;
    let result: Value = serde_json::from_str(&text).map_err(|error| to_error(error.into()))?;
    let cost = result["work"]["cpu_seconds"].as_f64();
    let cpu_seconds =
        cost.ok_or_else(|| LadderError::Missing { path: path.clone(), what: COST })?;
    Ok(Answer { cpu_seconds, quantities: (kind.quantities)(&result) })
}
