//! What a case is, and what it may ask of the run it is part of.

use std::fmt;
use std::ops::Deref;
use std::sync::{Mutex, PoisonError};

use reference_problems::context;
pub use reference_problems::context::{CaseError, Profile, Shared, SharedTypeError};

use crate::claim::Subject;
use crate::report::Claim;

/// The result of a case: its claims, unless another type is named.
pub type CaseResult<T = Vec<Claim>> = Result<T, CaseError>;

/// What a case does, and whether others may run beside it.
///
/// A claim that does not hold is no error; an error is a case that could not be judged.
#[derive(Debug, Clone, Copy)]
pub enum Run {
    /// On one core, with others on the other cores.
    Together(fn(&Context<'_>) -> CaseResult),
    /// On all cores after the others, since it measures time or kills processes.
    Alone(fn(&Context<'_>) -> CaseResult),
}

/// One entry of the table [`crate::cases::ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Begins with the crate, e.g. `fpk-sph/viscous-damper`.
    pub id: &'static str,
    /// One line for the reader.
    pub title: &'static str,
    /// Where the problem and its reference come from.
    pub source: &'static str,
    /// The smallest profile that runs it; larger ones run it too.
    pub cost: Profile,
    /// Runs it.
    pub run: Run,
}

/// What a running case is given; what a chart is given too is that of [`context::Context`].
#[derive(Debug)]
pub struct Context<'a> {
    inner: context::Context<'a>,
    /// What the case left out, and why.
    skipped: Mutex<Vec<String>>,
}

impl<'a> Deref for Context<'a> {
    type Target = context::Context<'a>;

    fn deref(&self) -> &Self::Target {
        &self.inner
    }
}

impl<'a> Context<'a> {
    /// `progress` receives a few words on what is being done.
    #[must_use]
    pub const fn new(
        id: &'a str,
        profile: Profile,
        shared: &'a Shared,
        progress: &'a (dyn Fn(&str) + Sync),
    ) -> Self {
        let inner = context::Context::new(id, profile, shared, progress);
        Self { inner, skipped: Mutex::new(Vec::new()) }
    }

    /// What a claim of this case is about; `name` follows the id of the case, e.g. `second-moment-q/t6`.
    #[must_use]
    pub fn subject(
        &self,
        name: impl fmt::Display,
        quantity: impl Into<String>,
        method: impl Into<String>,
    ) -> Subject {
        Subject::new(format!("{}/{name}", self.id), quantity, method)
    }

    /// Claims of one run: `id` begins their names, unless it is empty.
    #[must_use]
    pub fn lines(&self, id: impl Into<String>, method: impl Into<String>) -> Lines<'_> {
        Lines { context: self, id: id.into(), method: method.into() }
    }

    /// Reports what is not claimed here and why, e.g. `ranks of mpirun: it is not installed`: it is printed below the claims.
    pub fn skip(&self, what_and_why: &str) {
        self.skipped.lock().unwrap_or_else(PoisonError::into_inner).push(what_and_why.to_owned());
    }

    /// What was skipped, in the order of the calls.
    #[must_use]
    pub fn into_skipped(self) -> Vec<String> {
        self.skipped.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Claims of one run of a case: the prefix of their ids, empty for none, and the method of the run.
#[derive(Debug, Clone)]
pub struct Lines<'a> {
    /// Context of the case.
    pub context: &'a Context<'a>,
    /// Prefix of the ids.
    pub id: String,
    /// With which method, resolution and sample count.
    pub method: String,
}

impl Lines<'_> {
    /// What a claim of the run is about.
    #[must_use]
    pub fn of(&self, name: impl fmt::Display, quantity: impl Into<String>) -> Subject {
        let slash = if self.id.is_empty() { "" } else { "/" };
        self.context.subject(format!("{}{slash}{name}", self.id), quantity, self.method.as_str())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A case that claims nothing.
    pub(crate) const fn case(id: &'static str, cost: Profile) -> Case {
        Case { id, title: "t", source: "s", cost, run: Run::Together(|_| Ok(Vec::new())) }
    }

    #[test]
    fn the_id_of_a_claim_begins_with_its_case() {
        let shared = Shared::default();
        let context = Context::new("crate/scene", Profile::Quick, &shared, &|_| {});
        assert_eq!(
            context.subject("moment/t6", "E[q^2]", "fit").unit("m^2").id,
            "crate/scene/moment/t6"
        );
    }
}
