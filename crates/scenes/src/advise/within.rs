//! A scene run by its own method at the size that a tolerance needs.

use std::io::Write;
use std::path::{Path, PathBuf};

use figures::number::short;
use serde_json::Value;

use super::{Advice, AdviseError, Options, Tried, Unreached, advise_on};
use crate::kind::{self, Progress, SceneKind, kind_of};
use crate::ladder::{Quantity, read_answer};
use crate::scene::SceneFile;

/// A run to a tolerance.
#[derive(Debug)]
pub struct Within {
    /// What it wrote.
    pub files: Vec<PathBuf>,
    /// The method with its size in words.
    pub label: String,
    /// The quantities that were asked for and are known to within themselves, with what the run itself tells of their error.
    pub quantities: Vec<Quantity>,
}

impl Within {
    /// Whether every error that the run tells is within the tolerance.
    #[must_use]
    pub fn is_reached(&self, tolerance: f64) -> bool {
        self.largest().is_some_and(|(error, _)| error <= tolerance)
    }

    /// The largest error over its scale, and of what. A quantity without an error has an infinite one.
    fn largest(&self) -> Option<(f64, &Quantity)> {
        let relative = |quantity: &Quantity| {
            quantity.error.map_or(f64::INFINITY, |error| error / quantity.scale)
        };
        let all = self.quantities.iter().map(|quantity| (relative(quantity), quantity));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Runs a scene by its own method, refined or coarsened to what trials say the tolerance needs.
///
/// # Errors
/// [`AdviseError::NotReached`] where the trials do not tell of such a size, and those of a run.
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
    let files = kind.run_file(&refined, options, progress)?;
    let judged: Vec<&str> = (0..advice.judgements.len())
        .filter(|&q| advice.is_known(q))
        .map(|q| advice.judgements[q].id.as_str())
        .collect();
    let mut quantities = read_answer(kind, &options.out)?.quantities;
    quantities.retain(|quantity| judged.contains(&quantity.id.as_str()));
    Ok(Within { files, label, quantities })
}

/// The quantity that is farthest off, and why it stays so.
fn not_reached(advice: &Advice) -> AdviseError {
    let missed = (0..advice.judgements.len()).filter(|&q| advice.is_known(q)).filter_map(|q| {
        let words = advice.judgements[q].words.as_str();
        match advice.needs[q].first()? {
            Err(Unreached::NotFalling { error }) => Some((*error, words, "does not fall")),
            Err(Unreached::TooFar { error }) => {
                Some((*error, words, "falls, and the rest is too far to tell"))
            }
            Ok(_) | Err(Unreached::NoAnswer) => None,
        }
    });
    let farthest = missed.max_by(|a, b| a.0.total_cmp(&b.0));
    let reason = farthest.map_or_else(
        || "no quantity is known to within itself".to_owned(),
        |(error, words, why)| format!("the error of {words} is {} and {why}", short(Some(error))),
    );
    let method = advice.ladder.methods[0].name.clone();
    AdviseError::NotReached { method, tolerance: advice.options.tolerance, reason }
}

/// Prints the files, and whether the run tells of the tolerance.
///
/// # Errors
/// [`AdviseError::Write`].
pub fn print_within(
    within: &Within,
    wanted: &Options,
    output: &mut dyn Write,
) -> Result<(), AdviseError> {
    for path in &within.files {
        writeln!(output, "{}", path.display()).map_err(AdviseError::Write)?;
    }
    let Some((error, quantity)) = within.largest() else { return Ok(()) };
    let verdict = if error <= wanted.tolerance { "within" } else { "NOT within" };
    writeln!(
        output,
        "{}: {verdict} {}; the largest error is {}, of {}",
        within.label,
        wanted.tolerance,
        short(Some(error)),
        quantity.words
    )
    .map_err(AdviseError::Write)
}
