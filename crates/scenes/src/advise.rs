//! The cheapest method and size for a tolerance on a user's own scene, from short trial runs.
//!
//! Every method climbs its ladder of sizes as far as the budget goes. A trial's error is what the run tells of itself, or what other
//! trials contradict it by, whichever is more; from there error and cost are carried on to the size that the tolerance needs.

mod curve;
mod judgement;
mod within;
mod words;

use std::path::Path;
use std::sync::Arc;

pub use self::curve::{Curve, Needed, Point, Unreached};
pub use self::judgement::{Judgement, judge};
pub use self::within::{Within, print_within, run_within};
pub use self::words::print;
use crate::kind::{Progress, RunError, SceneKind, kind_of};
use crate::ladder::{self, Ladder, LadderError, Outcome, Rung, Trial};
use crate::scene::SceneFile;

/// Sizes are told for so much of the tolerance: an error that is carried on is itself not certain.
const MARGIN: f64 = 0.8;

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The largest error that is allowed, over the scale of each quantity.
    pub tolerance: f64,
    /// No trial run is begun that is expected to cost more (CPU s); the first of each method always is.
    pub budget: f64,
    /// Beginnings of ids of quantities; none asks for all.
    pub quantities: Vec<String>,
}

impl Options {
    /// The dearest trial, where nothing else is said (CPU s).
    pub const BUDGET: f64 = 5.0;
}

/// Why there is no advice.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum AdviseError {
    /// The scene is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// A trial could not be made.
    #[error(transparent)]
    Ladder(#[from] LadderError),
    /// A tolerance that is none.
    #[error("the tolerance is {tolerance}; it must lie between 0 and 1")]
    Tolerance {
        /// What was given.
        tolerance: f64,
    },
    /// A budget that is none.
    #[error("the budget of a trial is {budget} s; it must be greater than 0")]
    Budget {
        /// What was given.
        budget: f64,
    },
    /// No trial has an answer.
    #[error("no trial run came to an end; the first ended in: {reason}")]
    NoAnswer {
        /// Why the first did not.
        reason: String,
    },
    /// The scene's own method does not reach the tolerance.
    #[error("{method} is not seen to reach {tolerance}: {reason}")]
    #[diagnostic(help(
        "`advise` tells what other methods of this scene do; --budget sees further, --quantity asks for less"
    ))]
    NotReached {
        /// The method.
        method: String,
        /// What was asked.
        tolerance: f64,
        /// Which quantity it misses, and by what.
        reason: String,
    },
    /// The scene has no such quantity.
    #[error("the scene has no quantity that begins with `{prefix}`")]
    NoQuantity {
        /// What was asked.
        prefix: String,
        /// Those that there are.
        #[help]
        help: String,
    },
    /// The terminal could not be written.
    #[error("cannot write the advice")]
    Write(#[source] std::io::Error),
}

impl From<crate::scene::SceneError> for AdviseError {
    fn from(error: crate::scene::SceneError) -> Self {
        Self::Run(error.into())
    }
}

/// What is advised, and what it rests on.
#[derive(Debug)]
pub struct Advice {
    /// What was asked.
    pub options: Options,
    /// The scene and its methods.
    pub ladder: Arc<Ladder>,
    /// What was tried.
    pub trials: Vec<Trial>,
    /// What the trials know of each quantity.
    pub judgements: Vec<Judgement>,
    /// For each quantity that is known well enough: what each method needs.
    pub needs: Vec<Vec<Result<Needed, Unreached>>>,
}

/// A method at the size that it needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its place in [`Ladder::methods`].
    pub method: usize,
    /// Size, cost and error that are expected.
    pub needed: Needed,
}

impl Advice {
    /// Whether the trials know a quantity to within itself: of others nothing is advised.
    #[must_use]
    pub fn is_known(&self, quantity: usize) -> bool {
        let judgement = &self.judgements[quantity];
        judgement.error < judgement.scale
    }

    /// Methods that reach the tolerance for one quantity, the cheapest first.
    #[must_use]
    pub fn candidates(&self, quantity: usize) -> Vec<Candidate> {
        let needed = self.needs[quantity].iter().enumerate();
        let candidates = needed
            .filter_map(|(method, need)| Some(Candidate { method, needed: *need.as_ref().ok()? }));
        by_cost(candidates.collect())
    }

    /// Methods that reach the tolerance for every known quantity, the cheapest first.
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

    /// The scene solved by a candidate.
    #[must_use]
    pub fn rung(&self, candidate: &Candidate) -> Option<Rung> {
        (self.ladder.methods[candidate.method].rung)(candidate.needed.size)
    }
}

fn by_cost(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.sort_by(|a, b| a.needed.cost.total_cmp(&b.needed.cost));
    candidates
}

/// Which methods are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tried {
    /// Every one that solves the scene.
    All,
    /// The scene's own.
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

/// As [`advise`], on a scene that was read.
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
    let mut trials = Vec::new();
    for method in 0..ladder.methods.len() {
        trials.extend(ladder::climb(kind, file, &ladder, method, budget, |method, rung| {
            progress.stage(&format!("trial: {}", method.at(&rung.label)));
        })?);
    }
    from_trials(Arc::new(ladder), trials, options)
}

/// What trials say.
///
/// # Errors
/// [`AdviseError::NoAnswer`], [`AdviseError::NoQuantity`].
pub fn from_trials(
    ladder: Arc<Ladder>,
    trials: Vec<Trial>,
    options: &Options,
) -> Result<Advice, AdviseError> {
    let ids = ids(&trials)?;
    for prefix in &options.quantities {
        if !ids.iter().any(|id| id.starts_with(prefix)) {
            let (prefix, help) = (prefix.clone(), format!("there are: {}", ids.join(", ")));
            return Err(AdviseError::NoQuantity { prefix, help });
        }
    }
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

/// The ids of all quantities, in the order of the results.
fn ids(trials: &[Trial]) -> Result<Vec<String>, AdviseError> {
    let mut ids: Vec<String> = Vec::new();
    for quantity in trials.iter().filter_map(Trial::answer).flat_map(|answer| &answer.quantities) {
        if !ids.contains(&quantity.id) {
            ids.push(quantity.id.clone());
        }
    }
    if ids.is_empty() {
        let reason = trials.iter().find_map(|trial| match &trial.outcome {
            Outcome::Failed { reason } => Some(reason.clone()),
            Outcome::Answered(_) => None,
        });
        let reason = reason.unwrap_or_else(|| "a result without quantities".to_owned());
        return Err(AdviseError::NoAnswer { reason });
    }
    Ok(ids)
}
