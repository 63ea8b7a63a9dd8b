//! Trial runs of rungs.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::{Answer, Ladder, Method, Rung};
use crate::causes::with_causes;
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
    },
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
        /// JSON pointer.
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
}

/// Runs a method at increasing sizes, each about three times as expensive as the last.
///
/// It stops when the next run would cost more than `budget` (CPU s), or after two failures in a row. `tell` is called
/// before each run.
///
/// # Errors
/// [`LadderError`]; a run that ends in an error is an outcome.
pub fn climb(
    kind: &SceneKind,
    file: &SceneFile,
    ladder: &Ladder,
    method: usize,
    budget: f64,
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
        let trial = try_rung(kind, file, method, rung)?;
        let cost = trial.answer().map(|answer| answer.cpu_seconds);
        trials.push(trial);
        match cost {
            Some(cost) if is_next_beyond(cost, budget) => break,
            Some(_) => failures = 0,
            None if failures == MOST_FAILURES => break,
            None => failures += 1,
        }
    }
    Ok(trials)
}

/// Whether the rung after one of this cost is expected to exceed a budget.
#[must_use]
pub fn is_next_beyond(cost: f64, budget: f64) -> bool {
    cost * super::COST_FACTOR > budget
}

/// Number of consecutive failures after which a method is abandoned: a lattice can be too coarse, not too fine.
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
    let outcome = try_scene(kind, file, &rung.trial)?;
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
        let outcome = try_scene(kind, file, &trial.rung.trial)?;
        if let Outcome::Answered(answer) = outcome {
            costs.push(answer.cpu_seconds);
        }
    }
    costs.sort_by(f64::total_cmp);
    Ok(costs)
}

/// Runs a scene derived from `file`; relative paths start from the folder of `file`.
///
/// # Errors
/// [`LadderError`]; a run that ends in an error is an outcome.
pub fn try_scene(
    kind: &SceneKind,
    file: &SceneFile,
    scene: &Map<String, Value>,
) -> Result<Outcome, LadderError> {
    let folder = tempfile::tempdir().map_err(LadderError::Folder)?;
    let scene = file.with_keys(Value::Object(scene.clone()));
    let options = Options::new(folder.path()).without_page();
    Ok(match kind.run_file(&scene, &options, &Progress::silent()) {
        Ok(_) => Outcome::Answered(read_answer(kind, folder.path())?),
        Err(error) => Outcome::Failed { reason: with_causes(&error) },
    })
}

/// Reads the result in a folder.
///
/// # Errors
/// [`LadderError::Result`], [`LadderError::Missing`].
pub fn read_answer(kind: &SceneKind, folder: &Path) -> Result<Answer, LadderError> {
    const COST: &str = "/work/cpu_seconds";
    let path = folder.join("result.json");
    let to_error = |source| LadderError::Result { path: path.clone(), source };
    let text = std::fs::read_to_string(&path).map_err(to_error)?;
    let result: Value = serde_json::from_str(&text).map_err(|error| to_error(error.into()))?;
    let cost = result.pointer(COST).and_then(Value::as_f64);
    let cpu_seconds =
        cost.ok_or_else(|| LadderError::Missing { path: path.clone(), what: COST })?;
    Ok(Answer { cpu_seconds, quantities: (kind.quantities)(&result) })
}
