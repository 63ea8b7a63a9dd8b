//! Runs a scene by its own method at the size that a tolerance requires.

use std::io::Write;
use std::path::{Path, PathBuf};

use result_figures::number::short;
use serde_json::Value;

use super::{Advice, AdviseError, Options, Tried, Unreached, advise_on};
use crate::answers::{Answer, Role};
use crate::kind::{self, Found, Progress, RunError, SceneKind, kind_of};
use crate::scene::SceneFile;

/// A run to a tolerance.
#[derive(Debug)]
pub struct Within {
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Name of the method with its size.
    pub label: String,
    /// What the run found.
    pub found: Found,
    /// Why a file could not be written.
    pub unwritten: Option<RunError>,
    /// Selected answers whose error is smaller than their scale in the trials, with the run's own error estimates.
    pub judged: Vec<Answer>,
}

impl Within {
    /// Whether every error estimate of the run is within the tolerance.
    #[must_use]
    pub fn is_reached(&self, tolerance: f64) -> bool {
        self.largest().is_some_and(|(error, _)| error <= tolerance)
    }

    /// Largest error over its scale, with its quantity. A quantity without an error counts as infinite.
    fn largest(&self) -> Option<(f64, &Answer)> {
        let relative =
            |answer: &Answer| answer.margin().map_or(f64::INFINITY, |error| error / answer.scale);
        let all = self.judged.iter().map(|answer| (relative(answer), answer));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Runs a scene by its own method, with the size that the trials give for the tolerance.
///
/// # Errors
/// [`AdviseError::NotReached`] if the trials give no such size, and the errors of a run.
pub fn run_within(
    table: &[SceneKind],
    scene: &Path,
    options: &kind::Options,
    wanted: &Options,
    progress: &Progress,
) -> Result<Within, AdviseError> {
    let file = SceneFile::read(scene)?;
    let kind = kind_of(table, &file)?;
    let advice = advise_on(kind, &file, wanted, Tried::Own, progress)?;
    let candidates = advice.candidates_for_all();
    let best = candidates.first().ok_or_else(|| not_reached(&advice))?;
    let rung = advice.rung(best).ok_or_else(|| not_reached(&advice))?;
    let label = advice.ladder.methods[best.method].at(&rung.label);
    progress.stage(&label);
    let refined = file.with_keys(Value::Object(rung.scene));
    let kind::Finished { files, found, unwritten, .. } =
        kind.run_file(&refined, options, progress)?;
    let found = found.ok_or(RunError::NoShards)?;
    let is_judged = |answer: &&Answer| {
        answer.role != Role::Shown
            && (0..advice.judgements.len())
                .any(|q| advice.is_known(q) && advice.judgements[q].id == answer.id)
    };
    let judged = found.answers.list.iter().filter(is_judged).cloned().collect();
    Ok(Within { files, label, found, unwritten, judged })
}

/// The quantity with the largest error, and the reason.
fn not_reached(advice: &Advice) -> AdviseError {
    let missed = (0..advice.judgements.len()).filter(|&q| advice.is_known(q)).filter_map(|q| {
        let words = advice.judgements[q].words.as_str();
        match advice.needs[q].first()? {
            Err(Unreached::NotFalling { error }) => Some((*error, words, "does not decrease")),
            Err(Unreached::TooFar { error }) => {
                Some((*error, words, "decreases, but the required size is too far from the trials"))
            }
            Ok(_) | Err(Unreached::NoAnswer) => None,
        }
    });
    let farthest = missed.max_by(|a, b| a.0.total_cmp(&b.0));
    let reason = farthest.map_or_else(
        || "no quantity has an error smaller than its scale".to_owned(),
        |(error, words, why)| format!("the error of {words} is {} and {why}", short(Some(error))),
    );
    let method = advice.ladder.methods[0].name.clone();
    AdviseError::NotReached { method, tolerance: advice.options.tolerance, reason }
}

/// Prints whether the error estimates are within the tolerance.
///
/// # Errors
/// [`AdviseError::Write`].
pub fn print_within(
    within: &Within,
    wanted: &Options,
    output: &mut dyn Write,
) -> Result<(), AdviseError> {
    let Some((error, answer)) = within.largest() else { return Ok(()) };
    let verdict = if error <= wanted.tolerance { "within" } else { "NOT within" };
    writeln!(
        output,
        "{}: {verdict} {}; the largest error is {}, of {}",
        within.label,
        wanted.tolerance,
        short(Some(error)),
        answer.words
    )
    .map_err(AdviseError::Write)
}
