//! Context that a chart or a case receives while it runs.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;
use serde::{Deserialize, Serialize};

/// Error of a case, a chart or a scene: any typed error, so that `?` converts all of them.
pub type CaseError = Box<dyn std::error::Error + Send + Sync>;

/// Amount of work.
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
    /// The profile of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Quick, Self::Default, Self::Full].into_iter().find(|profile| profile.name() == name)
    }

    /// Name used in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Default => "default",
            Self::Full => "full",
        }
    }
}

/// Amount of work.
#[derive(Debug, Clone, Copy, Args)]
#[group(multiple = false)]
pub struct Extent {
    /// The cheapest part, at most 3 minutes
    #[arg(long)]
    quick: bool,
    /// Everything, at most 90 minutes
    #[arg(long)]
    full: bool,
}

impl Extent {
    /// Profile selected by the flags.
    #[must_use]
    pub const fn profile(self) -> Profile {
        match (self.quick, self.full) {
            (true, _) => Profile::Quick,
            (_, true) => Profile::Full,
            _ => Profile::Default,
        }
    }
}

/// Results common to several cases, computed once per run.
#[derive(Debug, Default)]
pub struct Shared {
    results: Mutex<BTreeMap<String, Arc<Slot>>>,
}

/// A result, once computed.
type Slot = Mutex<Option<Arc<dyn Any + Send + Sync>>>;

/// A result under this key has another type.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("the shared result `{key}` is not a {expected}")]
pub struct SharedTypeError {
    /// Its key.
    pub key: String,
    /// Requested type.
    pub expected: &'static str,
}

/// Context of a running case.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The id of the case, or the name of the chart.
    pub id: &'a str,
    /// Amount of work.
    pub profile: Profile,
    shared: &'a Shared,
    progress: &'a (dyn Fn(&str) + Sync),
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
    /// A context; `progress` receives short descriptions of the current work.
    #[must_use]
    pub const fn new(
        id: &'a str,
        profile: Profile,
        shared: &'a Shared,
        progress: &'a (dyn Fn(&str) + Sync),
    ) -> Self {
        Self { id, profile, shared, progress }
    }

    /// Reports the current work.
    pub fn progress(&self, what: &str) {
        (self.progress)(what);
    }

    /// The result stored under `key`, computed if this is the first request.
    ///
    /// An error is not stored: the next case that requests it computes it again and reports its own error.
    ///
    /// # Errors
    /// Errors of `compute`; [`SharedTypeError`] if `key` holds a value of another type.
    pub fn shared<T: Any + Send + Sync>(
        &self,
        key: &str,
        compute: impl FnOnce() -> Result<T, CaseError>,
    ) -> Result<Arc<T>, CaseError> {
        let slot = {
            let mut results = self.shared.results.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(results.entry(key.into()).or_default())
        };
        // Other requests wait; the table is unlocked, so one shared result may use another.
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        let result: Arc<dyn Any + Send + Sync> = match &*slot {
            Some(result) => Arc::clone(result),
            None => Arc::clone(slot.insert(Arc::new(compute()?))),
        };
        drop(slot);
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
        let shared = Shared::default();
        let context = Context::new("self-check/shared", Profile::Quick, &shared, &|_| {});
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
        let shared = Shared::default();
        let context = Context::new("self-check/shared", Profile::Quick, &shared, &|_| {});
        context.shared("run", || Ok(1.0_f64)).unwrap();
        let error = context.shared("run", || Ok(1_u32)).unwrap_err();
        assert_eq!(error.to_string(), "the shared result `run` is not a u32");
    }

    #[test]
    fn a_failed_computation_is_not_stored() {
        let shared = Shared::default();
        let context = Context::new("self-check/shared", Profile::Quick, &shared, &|_| {});
        assert!(context.shared::<u32>("run", || Err("it failed".into())).is_err());
        assert_eq!(*context.shared("run", || Ok(3_u32)).unwrap(), 3);
    }
}
