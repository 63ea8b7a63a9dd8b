//! Trial runs of rungs, in memory.

use std::time::Duration;

use serde_json::{Map, Value};

use super::{COST_FACTOR, Ladder, Method, Rung};
use crate::answers::Answers;
use crate::causes::with_causes;
use crate::clock::CpuClock;
use crate::kind::{Progress, SceneKind};
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
    /// The answers of the run.
    Answered(Answers),
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

impl Outcome {
    /// The answers, if there are any.
    #[must_use]
    pub const fn answers(&self) -> Option<&Answers> {
        match self {
            Self::Answered(answers) => Some(answers),
            Self::Failed { .. } => None,
        }
    }
}

impl Trial {
    /// The answers, if there are any.
    #[must_use]
    pub const fn answers(&self) -> Option<&Answers> {
        self.outcome.answers()
    }

    /// CPU time (s), whether it ended in answers or in an error.
    #[must_use]
    pub const fn cpu_seconds(&self) -> f64 {
        match &self.outcome {
            Outcome::Answered(Answers { cpu_seconds, .. })
            | Outcome::Failed { cpu_seconds, .. } => *cpu_seconds,
        }
    }
}

/// Runs a method at increasing sizes, each about three times as expensive as the last.
///
/// It stops when the next run would cost more than the budget, after three failures in a row, and where the cost does not grow
/// with the size: that trial has failed with the reason. `tell` is called before each run.
pub fn climb(
    kind: &SceneKind,
    file: &SceneFile,
    ladder: &Ladder,
    method: usize,
    limits: Limits,
    mut tell: impl FnMut(&Method, &Rung),
) -> Vec<Trial> {
    let climbed = &ladder.methods[method];
    let (mut trials, mut size, mut failures) = (Vec::<Trial>::new(), climbed.first, 0);
    let mut growth = CostGrowth::default();
    while let Some(rung) = (climbed.rung)(size) {
        // Rounding can make two sizes equal.
        let is_new = trials.last().is_none_or(|last| last.rung.size < rung.size);
        size = rung.size.max(size) * climbed.growth.factor();
        if !is_new {
            continue;
        }
        tell(climbed, &rung);
        let outcome = try_scene(kind, file, &rung.trial, limits.longest);
        let mut trial = Trial { method, rung, outcome };
        let (cost, is_answered) = (trial.cpu_seconds(), trial.answers().is_some());
        if growth.has_ended(cost) {
            let reason = format!(
                "{MOST_LEVEL} larger trials cost no more than {:.2} CPU s: the cost does not grow with the size",
                growth.dearest
            );
            trial.outcome = Outcome::Failed { reason, cpu_seconds: cost };
            trials.push(trial);
            break;
        }
        trials.push(trial);
        failures = if is_answered { 0 } else { failures + 1 };
        if is_next_beyond(cost, limits.budget) || failures > MOST_FAILURES {
            break;
        }
    }
    trials
}

/// Whether the rung after one of this cost is expected to exceed a budget.
#[must_use]
pub fn is_next_beyond(cost: f64, budget: f64) -> bool {
    cost * COST_FACTOR > budget
}

/// Consecutive trials that may cost less than [`LEAST_GROWTH`] times the dearest before. Their expected cost grows 6,500-fold,
/// beyond what a run costs at any size.
const MOST_LEVEL: u32 = 8;
/// Growth of the cost that counts.
const LEAST_GROWTH: f64 = 1.2;

/// Growth of the cost of successive trials.
#[derive(Debug, Default)]
struct CostGrowth {
    /// Largest cost (CPU s).
    dearest: f64,
    /// Number of trials since the cost has grown.
    level: u32,
}

impl CostGrowth {
    /// Adds the cost of a trial; returns whether the cost no longer grows.
    fn has_ended(&mut self, cost: f64) -> bool {
        self.level = if cost > LEAST_GROWTH * self.dearest { 0 } else { self.level + 1 };
        self.dearest = self.dearest.max(cost);
        self.level >= MOST_LEVEL
    }
}

/// Consecutive failures that a method may have; one more ends its trials. A lattice can be too coarse, not too fine.
const MOST_FAILURES: u32 = 2;

/// Runs a scene derived from `file` in memory; relative paths start from the folder of `file`.
///
/// The run ends with an error if the projected time of a part exceeds `longest`. An error of the run is an outcome.
#[must_use]
pub fn try_scene(
    kind: &SceneKind,
    file: &SceneFile,
    scene: &Map<String, Value>,
    longest: Option<Duration>,
) -> Outcome {
    let scene = file.with_keys(Value::Object(scene.clone()));
    let clock = CpuClock::start();
    match kind.solve(&scene, longest, &Progress::silent()) {
        Ok(answers) => Outcome::Answered(answers),
        Err(error) => Outcome::Failed { reason: with_causes(&error), cpu_seconds: clock.seconds() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cost_that_no_longer_grows_ends_a_ladder_and_one_that_grows_late_does_not() {
        let first_end = |costs: &[f64]| {
            let mut growth = CostGrowth::default();
            costs.iter().position(|&cost| growth.has_ended(cost))
        };
        // The same cost at any size: the first trial and eight more.
        assert_eq!(first_end(&[0.03; 30]), Some(8));
        // A fixed cost of 0.2 s, under which that of the size is hidden for five trials.
        let late: Vec<f64> = (0..12).map(|k| 0.2 + 1e-4 * COST_FACTOR.powi(k)).collect();
        assert_eq!(first_end(&late), None);
    }
}
