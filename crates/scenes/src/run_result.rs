//! `result.json`: what every run writes, whatever solved the scene.

use std::path::{Path, PathBuf};

use sde_integrators::{Estimate, Uncertainty};
use serde::Serialize;

use crate::machine::{Machine, commit};
use crate::output::{OutputError, write_json};

/// The fields that every result begins with, then those of its schema.
#[derive(Debug, Serialize)]
pub struct RunResult<'a, S, C> {
    schema: &'static str,
    version: &'static str,
    commit: Option<String>,
    machine: Machine,
    /// The scene as it was understood.
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

/// What a run does not know, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unknown {
    /// The quantities, and from when on.
    pub what: String,
    /// Why.
    pub reason: String,
}

/// Where an error comes from.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorOrigin {
    /// Runs at a coarser resolution, and the order of the method.
    TwoResolutions,
    /// The spread of samples.
    StandardError,
    /// A bound.
    Bound,
    /// A count.
    Exact,
    /// No error is known.
    Unknown,
}

/// The error of an estimate, and where it comes from.
#[must_use]
pub const fn error_of(estimate: &Estimate) -> (Option<f64>, ErrorOrigin) {
    match estimate.uncertainty {
        Uncertainty::StandardError(error) => (Some(error), ErrorOrigin::StandardError),
        Uncertainty::Bound(error) => (Some(error), ErrorOrigin::Bound),
        Uncertainty::Unknown => (None, ErrorOrigin::Unknown),
    }
}
