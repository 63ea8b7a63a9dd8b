//! Rungs that are run.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::{Answer, Ladder, Method, Rung};
use crate::causes::with_causes;
use crate::kind::{Options, Progress, SceneKind};
use crate::scene::SceneFile;

/// A rung that was run.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The place of its method in [`Ladder::methods`].
    pub method: usize,
    /// What was run.
    pub rung: Rung,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of a rung.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// An answer.
    Answered(Answer),
    /// The run ended in an error.
    Failed {
        /// Its words.
        reason: String,
    },
}

/// Why a rung could not be tried at all.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum LadderError {
    /// There is no place for the results of trials.
    #[error("no folder for trial runs")]
    Folder(#[source] std::io::Error),
    /// A result is not there or no JSON.
    #[error("the result of a trial run cannot be read: {}", .path.display())]
    Result {
        /// Where it was looked for.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A result does not hold what the kind of scene says.
    #[error("the result of a run has no number {what}: {}", .path.display())]
    Missing {
        /// The result.
        path: PathBuf,
        /// The JSON pointer.
        what: &'static str,
    },
}

impl Trial {
    /// The answer, where there is one.
    #[must_use]
    pub const fn answer(&self) -> Option<&Answer> {
        match &self.outcome {
            Outcome::Answered(answer) => Some(answer),
            Outcome::Failed { .. } => None,
        }
    }
}

/// Runs a method at rising sizes, each about three times as dear as the one before, until the next would cost more than `budget`
/// (CPU s) or fails twice in a row. `tell` hears of each run before it begins.
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
        // Rounding can make two sizes the same.
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

/// Whether the rung after one of this cost is expected to cost more than a budget.
#[must_use]
pub fn is_next_beyond(cost: f64, budget: f64) -> bool {
    cost * super::COST_FACTOR > budget
}

/// Failures in a row after which a method is given up: a lattice can be too coarse, not too fine.
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

/// The CPU times (s) of a trial and of so many runs like it, in rising order; empty where the trial has no answer.
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

/// Runs a scene that is made of `file`, whose folder its paths start from.
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
    let options = Options::new(folder.path());
    Ok(match kind.run_file(&scene, &options, &Progress::silent()) {
        Ok(_) => Outcome::Answered(read_answer(kind, folder.path())?),
        Err(error) => Outcome::Failed { reason: with_causes(&error) },
    })
}

/// What the result in a folder holds.
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
