//! `result.json`: the output common to all scene kinds.

use std::path::{Path, PathBuf};

use sde_integrators::{Estimate, Uncertainty};
use serde::Serialize;

use crate::machine::{Machine, commit};
use crate::output::{OutputError, write_json};

/// Common fields of every result, followed by those of its schema.
#[derive(Debug, Serialize)]
pub struct RunResult<'a, S, C> {
    schema: &'static str,
    version: &'static str,
    commit: Option<String>,
    machine: Machine,
    /// The parsed scene.
    scene: &'a S,
    #[serde(flatten)]
    content: C,
}

impl<'a, S: Serialize, C: Serialize> RunResult<'a, S, C> {
    /// The result of a scene on this machine.
    #[must_use]
    pub fn new(schema: &'static str, scene: &'a S, content: C) -> Self {
        let (version, machine) = (env!("CARGO_PKG_VERSION"), Machine::read());
        Self { schema, version, commit: commit(), machine, scene, content }
    }

    /// Writes `result.json` into a folder and returns its path.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn write(&self, folder: &Path) -> Result<PathBuf, OutputError> {
        let path = folder.join("result.json");
        write_json(&path, self)?;
        Ok(path)
    }
}

/// An unknown error or quantity, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unknown {
    /// The quantities, and from which time on.
    pub what: String,
    /// Reason.
    pub reason: String,
}

/// Source of an error estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorOrigin {
    /// Runs at a coarser resolution, with the order of the method.
    TwoResolutions,
    /// Scatter of samples.
    StandardError,
    /// A bound.
    Bound,
    /// A count.
    Exact,
    /// No error is known.
    Unknown,
}

/// Error of an estimate, and its source.
#[must_use]
pub const fn error_of(estimate: &Estimate) -> (Option<f64>, ErrorOrigin) {
    match estimate.uncertainty {
        Uncertainty::StandardError(error) => (Some(error), ErrorOrigin::StandardError),
        Uncertainty::Bound(error) => (Some(error), ErrorOrigin::Bound),
        Uncertainty::Unknown => (None, ErrorOrigin::Unknown),
    }
}

/// A number with its error.
#[cfg(feature = "peridyn")]
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Number {
    pub(crate) value: f64,
    pub(crate) error: Option<f64>,
    error_kind: ErrorOrigin,
}

#[cfg(feature = "peridyn")]
impl From<Estimate> for Number {
    fn from(estimate: Estimate) -> Self {
        let (error, error_kind) = error_of(&estimate);
        Self { value: estimate.value, error, error_kind }
    }
}
