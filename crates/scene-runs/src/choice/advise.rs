//! The cheapest method and size for a tolerance on a user's scene, from short trial runs.
//!
//! Every method climbs its ladder of sizes as far as the budget allows. The error of a trial is its own estimate, or
//! its deviation from other trials, whichever is larger. Error and cost are extrapolated to the size that the
//! tolerance requires.

mod curve;
mod judgement;
mod page;
mod within;
mod words;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

pub use self::curve::{Curve, Needed, Point, Unreached};
pub use self::judgement::{Judgement, judge};
pub use self::page::write_page;
pub use self::within::{Within, print_within, run_within};
pub use self::words::print;
use crate::answers::Answers;
use crate::kind::{Progress, RunError, SceneKind, kind_of};
use crate::ladder::{self, Ladder, Limits, Outcome, Rung, Trial};
use crate::scene::SceneFile;

/// Sizes are chosen for this fraction of the tolerance, because an extrapolated error is itself uncertain.
const MARGIN: f64 = 0.8;

/// Longest projected time (s) of a part of a trial over the budget (CPU s), where several methods are tried.
const PATIENCE: f64 = 10.0;

/// Options of the advice.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Largest admissible error, relative to the scale of each quantity.
    pub tolerance: f64,
    /// Largest expected cost of a trial run (CPU s). The first trial of each method always begins; where several methods are tried, it
    /// ends if the projected time of a part exceeds ten times this number.
    pub budget: f64,
    /// Prefixes of ids of quantities; an empty list selects all.
    pub quantities: Vec<String>,
}

impl Options {
    /// Default budget of a trial (CPU s).
    pub const BUDGET: f64 = 5.0;
}

/// Error of the advice.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum AdviseError {
    /// The scene is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// The tolerance is out of range.
    #[error("the tolerance is {tolerance}; it must lie between 0 and 1")]
    Tolerance {
        /// The tolerance given.
        tolerance: f64,
    },
    /// The budget is not positive.
    #[error("the budget of a trial is {budget} s; it must be greater than 0")]
    Budget {
        /// The budget given.
        budget: f64,
    },
    /// No trial has a result.
    #[error("no trial run finished; the first failed: {reason}")]
    NoAnswer {
        /// Error of the first trial.
        reason: String,
    },
    /// The scene's own method does not reach the tolerance.
    #[error("{method} does not reach {tolerance} in the trials: {reason}")]
    #[diagnostic(help(
        "run `advise` for the other methods of this scene, raise --budget, or select fewer quantities by --quantity"
    ))]
    NotReached {
        /// The method.
        method: String,
        /// The tolerance.
        tolerance: f64,
        /// The quantity that misses it, and its error.
        reason: String,
    },
    /// No quantity has this prefix.
    #[error("no quantity of the scene begins with `{prefix}`")]
    NoQuantity {
        /// The prefix given.
        prefix: String,
        /// Existing ids.
        #[help]
        help: String,
    },
    /// Standard output could not be written.
    #[error("cannot print the advice")]
    Write(#[source] std::io::Error),
}

impl From<crate::scene::SceneError> for AdviseError {
    fn from(error: crate::scene::SceneError) -> Self {
        Self::Run(error.into())
    }
}

/// Advice, with the trials behind it.
#[derive(Debug)]
pub struct Advice {
    /// Options given.
    pub options: Options,
    /// The scene and its methods.
    pub ladder: Arc<Ladder>,
    /// Trial runs.
    pub trials: Vec<Trial>,
    /// Combined result of the trials for each quantity.
    pub judgements: Vec<Judgement>,
    /// The size that each method requires, for each quantity that is known well enough.
    pub needs: Vec<Vec<Result<Needed, Unreached>>>,
}

/// A method at the size that it requires.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Index in [`Ladder::methods`].
    pub method: usize,
    /// Expected size, cost and error.
    pub needed: Needed,
}

impl Advice {
    /// Whether the error of a quantity is smaller than its scale; otherwise there is no advice for it.
    #[must_use]
    pub fn is_known(&self, quantity: usize) -> bool {
        let judgement = &self.judgements[quantity];
        judgement.error < judgement.scale
    }

    /// Methods that reach the tolerance for one quantity, cheapest first.
    #[must_use]
    pub fn candidates(&self, quantity: usize) -> Vec<Candidate> {
        let needed = self.needs[quantity].iter().enumerate();
        let candidates = needed
            .filter_map(|(method, need)| Some(Candidate { method, needed: *need.as_ref().ok()? }));
        by_cost(candidates.collect())
    }

    /// Methods that reach the tolerance for every known quantity, cheapest first.
    #[must_use]
    pub fn candidates_for_all(&self) -> Vec<Candidate> {
        let known: Vec<usize> = (0..self.judgements.len()).filter(|&q| self.is_known(q)).collect();
        let of = |method: usize| -> Option<Candidate> {
            let needs = known.iter().map(|&q| self.needs[q][method].as_ref().ok());
            let needs: Option<Vec<&Needed>> = needs.collect();
            let dearest = needs?.into_iter().max_by(|a, b| a.size.total_cmp(&b.size))?;
            Some(Candidate { method, needed: *dearest })
        };
        by_cost((0..self.ladder.methods.len()).filter_map(of).collect())
    }

    /// The scene with the method and size of a candidate.
    #[must_use]
    pub fn rung(&self, candidate: &Candidate) -> Option<Rung> {
        (self.ladder.methods[candidate.method].rung)(candidate.needed.size)
    }
}

fn by_cost(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.sort_by(|a, b| a.needed.cost.total_cmp(&b.needed.cost));
    candidates
}

/// Methods to try.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tried {
    /// Every method that solves the scene.
    All,
    /// The scene's own method.
    Own,
}

/// Advises on a scene file.
///
/// # Errors
/// [`AdviseError`].
pub fn advise(
    table: &[SceneKind],
    scene: &Path,
    options: &Options,
    progress: &Progress,
) -> Result<Advice, AdviseError> {
    let file = SceneFile::read(scene)?;
    advise_on(kind_of(table, &file)?, &file, options, Tried::All, progress)
}

/// Advises on a parsed scene, as [`advise`] does on a file.
///
/// # Errors
/// [`AdviseError`].
pub fn advise_on(
    kind: &SceneKind,
    file: &SceneFile,
    options: &Options,
    tried: Tried,
    progress: &Progress,
) -> Result<Advice, AdviseError> {
    let &Options { tolerance, budget, .. } = options;
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(AdviseError::Tolerance { tolerance });
    }
    if !(budget.is_finite() && budget > 0.0) {
        return Err(AdviseError::Budget { budget });
    }
    let mut ladder = (kind.ladder)(file)?;
    if tried == Tried::Own {
        ladder.methods.truncate(1);
    }
    // A single method has no cheaper alternative: its first trial runs to its end.
    let longest = Duration::try_from_secs_f64(PATIENCE * budget).ok();
    let limits = Limits { budget, longest: longest.filter(|_| tried == Tried::All) };
    let mut trials = Vec::new();
    for method in 0..ladder.methods.len() {
        trials.extend(ladder::climb(kind, file, &ladder, method, limits, |method, rung| {
            progress.stage(&format!("trial: {}", method.at(&rung.label)));
        }));
        // A misspelt quantity is reported before the other methods have run.
        if trials.iter().any(|it| it.answers().is_some()) {
            require_quantities(&ids(&trials)?, &options.quantities)?;
        }
    }
    from_trials(Arc::new(ladder), trials, options)
}

/// Derives advice from trials.
///
/// # Errors
/// [`AdviseError::NoAnswer`], [`AdviseError::NoQuantity`].
pub fn from_trials(
    ladder: Arc<Ladder>,
    trials: Vec<Trial>,
    options: &Options,
) -> Result<Advice, AdviseError> {
    let ids = ids(&trials)?;
    require_quantities(&ids, &options.quantities)?;
    let is_asked = |id: &&String| {
        options.quantities.is_empty() || options.quantities.iter().any(|p| id.starts_with(p))
    };
    let judgements: Vec<Judgement> =
        ids.iter().filter(is_asked).filter_map(|id| judge(&ladder, &trials, id)).collect();
    let need = |judgement: &Judgement| {
        let within = MARGIN * options.tolerance;
        judgement.curves.iter().map(|curve| curve.needed(within)).collect()
    };
    let needs = judgements.iter().map(need).collect();
    Ok(Advice { options: options.clone(), ladder, trials, judgements, needs })
}

fn require_quantities(ids: &[String], prefixes: &[String]) -> Result<(), AdviseError> {
    match prefixes.iter().find(|prefix| !ids.iter().any(|id| id.starts_with(*prefix))) {
        Some(prefix) => Err(AdviseError::NoQuantity {
            prefix: prefix.clone(),
            help: format!("available: {}", ids.join(", ")),
        }),
        None => Ok(()),
    }
}

/// Ids of all quantities, in the order of the results.
fn ids(trials: &[Trial]) -> Result<Vec<String>, AdviseError> {
    let mut ids: Vec<String> = Vec::new();
    for answer in trials.iter().filter_map(Trial::answers).flat_map(Answers::compared) {
        if !ids.contains(&answer.id) {
            ids.push(answer.id.clone());
        }
    }
    if ids.is_empty() {
        let reason = trials.iter().find_map(|trial| match &trial.outcome {
            Outcome::Failed { reason, .. } => Some(reason.clone()),
            Outcome::Answered(_) => None,
        });
        let reason = reason.unwrap_or_else(|| "a result without quantities".to_owned());
        return Err(AdviseError::NoAnswer { reason });
    }
    Ok(ids)
}
