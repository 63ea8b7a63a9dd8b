//! What a case is, and what it may ask of the run it is part of.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::claim::Subject;
use crate::report::Claim;

/// Why a case, a chart or a scene could not run to its end: any typed error, so that `?` takes them all.
pub type CaseError = Box<dyn std::error::Error + Send + Sync>;

/// How much is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// At most 3 minutes on two quiet cores.
    Quick,
    /// At most 15 minutes.
    Default,
    /// At most 90 minutes.
    Full,
}

impl Profile {
    /// The profile of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Quick, Self::Default, Self::Full].into_iter().find(|profile| profile.name() == name)
    }

    /// The word used in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Default => "default",
            Self::Full => "full",
        }
    }
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
    /// Runs it. A claim that does not hold is no error; an error is a case that could not be judged.
    pub run: fn(&Context<'_>) -> Result<Vec<Claim>, CaseError>,
}

/// Results that several cases use, computed once per run.
#[derive(Debug, Default)]
pub struct Shared {
    /// What the running case left out, and why.
    skipped: Mutex<Vec<String>>,
    results: Mutex<BTreeMap<String, Arc<dyn Any + Send + Sync>>>,
}

/// A result was stored under this key with another type.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("the shared result `{key}` is not a {expected}")]
pub struct SharedTypeError {
    /// Its key.
    pub key: String,
    /// The type asked for.
    pub expected: &'static str,
}

/// What a running case is given.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The id of the case, or the name of the chart.
    pub id: &'a str,
    /// How much is to be run.
    pub profile: Profile,
    shared: &'a Shared,
    charts: &'a Mutex<Vec<InlineChart>>,
    progress: &'a (dyn Fn(&str) + Sync),
}

/// A picture for the page of the report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct InlineChart {
    /// The case it belongs to.
    pub case_id: String,
    /// One line above the picture.
    pub title: String,
    /// The picture, `<svg ...>...</svg>`.
    pub svg: String,
}

impl std::fmt::Debug for Context<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Context")
            .field("id", &self.id)
            .field("profile", &self.profile)
            .finish_non_exhaustive()
    }
}

impl<'a> Context<'a> {
    /// `progress` is told in a few words what is being done.
    #[must_use]
    pub const fn new(
        id: &'a str,
        profile: Profile,
        shared: &'a Shared,
        charts: &'a Mutex<Vec<InlineChart>>,
        progress: &'a (dyn Fn(&str) + Sync),
    ) -> Self {
        Self { id, profile, shared, charts, progress }
    }

    /// What a claim of this case is about; `name` follows the id of the case, e.g. `second-moment-q/t6`.
    #[must_use]
    pub fn subject(&self, name: &str, quantity: &str, unit: &str, method: &str) -> Subject {
        Subject::new(format!("{}/{name}", self.id), quantity, unit, method)
    }

    /// Says what is not claimed here and why, e.g. `ranks of mpirun: it is not installed`: it stands below the claims.
    pub fn skip(&self, what_and_why: &str) {
        let mut skipped = self.shared.skipped.lock().unwrap_or_else(PoisonError::into_inner);
        skipped.push(what_and_why.to_owned());
    }

    /// What was said to be skipped since the last call.
    pub(crate) fn take_skipped(&self) -> Vec<String> {
        std::mem::take(&mut self.shared.skipped.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Says in a few words what is being done.
    pub fn progress(&self, what: &str) {
        (self.progress)(what);
    }

    /// Puts a picture on the page of the report, under this case.
    pub fn show_chart(&self, title: &str, svg: String) {
        let chart = InlineChart { case_id: self.id.into(), title: title.into(), svg };
        self.charts.lock().unwrap_or_else(PoisonError::into_inner).push(chart);
    }

    /// The result stored under `key`, computed now if this is the first case to ask.
    ///
    /// An error is not stored: the next case that asks tries again and reports it as its own.
    ///
    /// # Errors
    /// Those of `compute`; [`SharedTypeError`] if `key` holds a value of another type.
    pub fn shared<T: Any + Send + Sync>(
        &self,
        key: &str,
        compute: impl FnOnce() -> Result<T, CaseError>,
    ) -> Result<Arc<T>, CaseError> {
        let stored =
            self.shared.results.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned();
        let result = if let Some(result) = stored {
            result
        } else {
            // The lock is not held while computing, so one shared result may use another.
            let result: Arc<dyn Any + Send + Sync> = Arc::new(compute()?);
            let mut results = self.shared.results.lock().unwrap_or_else(PoisonError::into_inner);
            results.insert(key.into(), Arc::clone(&result));
            result
        };
        let expected = std::any::type_name::<T>();
        Ok(result.downcast::<T>().map_err(|_| SharedTypeError { key: key.into(), expected })?)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_shared_result_is_computed_once() {
        let (shared, charts) = (Shared::default(), Mutex::new(Vec::new()));
        let context = Context::new("self-check/shared", Profile::Quick, &shared, &charts, &|_| {});
        let runs = Cell::new(0);
        let ask = || {
            context.shared("run", || {
                runs.set(runs.get() + 1);
                Ok(vec![1.0, 2.0])
            })
        };
        assert_eq!(*ask().unwrap(), vec![1.0, 2.0]);
        assert_eq!(*ask().unwrap(), vec![1.0, 2.0]);
        assert_eq!(runs.get(), 1);
    }

    #[test]
    fn a_shared_result_of_another_type_is_refused() {
        let (shared, charts) = (Shared::default(), Mutex::new(Vec::new()));
        let context = Context::new("self-check/shared", Profile::Quick, &shared, &charts, &|_| {});
        context.shared("run", || Ok(1.0_f64)).unwrap();
        let error = context.shared("run", || Ok(1_u32)).unwrap_err();
        assert_eq!(error.to_string(), "the shared result `run` is not a u32");
    }

    #[test]
    fn a_failed_computation_is_not_stored() {
        let (shared, charts) = (Shared::default(), Mutex::new(Vec::new()));
        let context = Context::new("self-check/shared", Profile::Quick, &shared, &charts, &|_| {});
        assert!(context.shared::<u32>("run", || Err("it failed".into())).is_err());
        assert_eq!(*context.shared("run", || Ok(3_u32)).unwrap(), 3);
    }

    #[test]
    fn the_id_of_a_claim_begins_with_its_case() {
        let (shared, charts) = (Shared::default(), Mutex::new(Vec::new()));
        let context = Context::new("crate/scene", Profile::Quick, &shared, &charts, &|_| {});
        assert_eq!(
            context.subject("moment/t6", "E[q^2]", "m^2", "fit").id,
            "crate/scene/moment/t6"
        );
    }
}
