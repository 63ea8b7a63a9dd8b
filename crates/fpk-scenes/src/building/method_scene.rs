//! The method of a scene of a building.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::checks::must;

/// The method, by its name. Its paths take classical Runge-Kutta steps under noise that is constant over each step.
///
/// A first passage has a design point for every time, so that importance sampling about one does not apply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::MonteCarlo { paths: 100_000, step: 0.01, seed: 1 })]
#[schemars(example = Self::SubsetSimulation { samples: 500, correlation: 0.8, runs: 8, step: 0.01, seed: 1 })]
pub enum BuildingMethod {
    /// One set of paths guided to all thresholds and times.
    GuidedPaths {
        /// Number of paths; a fortieth as many pilot paths, at least 200, precede them (no unit).
        samples: u64,
        /// Longest step (s).
        step: f64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
    /// Monte Carlo: sampled paths.
    MonteCarlo {
        /// Number of paths (no unit).
        paths: u64,
        /// Longest step (s).
        step: f64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
    /// Subset simulation, for each time and threshold.
    SubsetSimulation {
        /// Number of paths per level, at least 100 (no unit).
        samples: usize,
        /// Correlation of the proposal with the current path, between 0 and 1 (no unit).
        correlation: f64,
        /// Number of independent runs, from 4 to 65536; the standard error is from their scatter (no unit).
        runs: u64,
        /// Longest step (s).
        step: f64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
}

impl BuildingMethod {
    /// Longest step (s).
    #[must_use]
    pub const fn step(&self) -> f64 {
        match *self {
            Self::GuidedPaths { step, .. }
            | Self::MonteCarlo { step, .. }
            | Self::SubsetSimulation { step, .. } => step,
        }
    }

    /// Seed of all random numbers.
    pub(super) const fn seed(&mut self) -> &mut u64 {
        match self {
            Self::GuidedPaths { seed, .. }
            | Self::MonteCarlo { seed, .. }
            | Self::SubsetSimulation { seed, .. } => seed,
        }
    }

    /// Name of its key in a scene.
    pub(super) const fn key(&self) -> &'static str {
        match self {
            Self::GuidedPaths { .. } => "guided_paths",
            Self::MonteCarlo { .. } => "monte_carlo",
            Self::SubsetSimulation { .. } => "subset_simulation",
        }
    }

    /// Rejects numbers outside their range; `stable` is the longest stable step.
    pub(super) fn check(&self, stable: f64) -> Result<(), Objection> {
        let path = |key: &str| format!("method.{}.{key}", self.key());
        let step = self.step();
        must(&path("step"), step, step > 0.0, "greater than 0")?;
        let limit = format!("at most {stable:.3}, where the steps of the fastest mode are stable");
        must(&path("step"), step, step <= stable, &limit)?;
        match *self {
            Self::GuidedPaths { samples, .. } => {
                must(&path("samples"), samples as f64, samples >= 100, "at least 100")
            }
            Self::MonteCarlo { paths, .. } => {
                must(&path("paths"), paths as f64, paths >= 2, "at least 2")
            }
            Self::SubsetSimulation { samples, correlation, runs, .. } => {
                must(&path("samples"), samples as f64, samples >= 100, "at least 100")?;
                let is_between = correlation > 0.0 && correlation < 1.0;
                must(&path("correlation"), correlation, is_between, "between 0 and 1")?;
                let few = (4..=65_536).contains(&runs);
                must(&path("runs"), runs as f64, few, "from 4 to 65536")
            }
        }
    }
}
