//! Methods of a scene of bodies as written in its JSON file.

use estimators::{Sampling, UnitCube};
use perturbation_moments::MonteCarlo;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::uncertainty::Design;

/// Method for mean and variance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Frozen { as_printed: true })]
#[schemars(example = Self::FiniteDifference { step: 0.01 })]
#[schemars(example = Self::ForwardDifference { step: 0.01 })]
#[schemars(example = Self::MonteCarlo { samples: 400, seed: 1, control: true })]
#[schemars(example = Self::QuasiMonteCarlo { points: 32, replicas: 8, seed: 1, control: true })]
#[schemars(example = Self::SobolIndices { points: 64, replicas: 8, seed: 1 })]
pub enum MethodScene {
    /// One run at the centre of the parameters, no variance.
    Deterministic,
    /// Derivatives at the local state, as in the paper: a baseline.
    Frozen {
        /// As printed in the paper, including its errors.
        #[serde(default)]
        as_printed: bool,
    },
    /// Derivatives carried through the run; with `random_fields`, through one run for every eight terms.
    Propagated,
    /// Central differences of whole runs.
    FiniteDifference {
        /// Step in standard deviations (no unit).
        step: f64,
    },
    /// One-sided differences of `N` whole runs, for `N` random parameters: the variance by the fewest runs.
    ForwardDifference {
        /// Step in standard deviations (no unit).
        step: f64,
    },
    /// `2N + 1` complete runs, three deviations wide, for `N` random parameters.
    SigmaPoints,
    /// Complete runs at sampled parameters.
    MonteCarlo {
        /// Number of samples (no unit).
        samples: u64,
        /// Seed of all random numbers (no unit).
        seed: u64,
        /// Whether to use a Taylor series as a control variate, from differences of `2N` more runs; with `random_fields`, from runs
        /// with derivatives.
        control: bool,
    },
    /// Complete runs at scrambled Sobol' points: a smaller error than by independent samples where responses are smooth.
    QuasiMonteCarlo {
        /// Points of a replica, a power of two (no unit).
        points: u64,
        /// Independent replicas, at least eight; their scatter is the standard error (no unit).
        replicas: u64,
        /// Seed of all random numbers (no unit).
        seed: u64,
        /// Whether to use a polynomial fitted to the runs as a control variate; it gives Sobol' indices, too.
        control: bool,
    },
    /// Mean, variance, and first-order and total Sobol' indices of each parameter, by `N + 2` complete runs for each point.
    SobolIndices {
        /// Points of a replica, a power of two (no unit).
        points: u64,
        /// Independent replicas, at least eight; their scatter is the standard error (no unit).
        replicas: u64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
}

impl MethodScene {
    /// The seed of a method that samples.
    pub(crate) const fn seed_mut(&mut self) -> Option<&mut u64> {
        match self {
            Self::MonteCarlo { seed, .. }
            | Self::QuasiMonteCarlo { seed, .. }
            | Self::SobolIndices { seed, .. } => Some(seed),
            _ => None,
        }
    }

    /// Whether a Taylor series is the control variate.
    pub(crate) const fn has_taylor_control(&self) -> bool {
        matches!(self, Self::MonteCarlo { control: true, .. })
    }

    /// The complete runs of a method that samples, for a number of random parameters.
    pub(crate) const fn design(&self, dimension: usize) -> Option<Design> {
        let sampling = Sampling::ScrambledSobol;
        match *self {
            Self::MonteCarlo { samples: n_samples, seed, .. } => {
                Some(Design::Random(MonteCarlo { seed, n_samples }))
            }
            Self::QuasiMonteCarlo { points: n_points, replicas: n_replicas, seed, .. } => {
                let cube = UnitCube { dimension, sampling, seed, n_points, n_replicas };
                Some(Design::QuasiRandom(cube))
            }
            Self::SobolIndices { points: n_points, replicas: n_replicas, seed } => {
                let cube = UnitCube { dimension, sampling, seed, n_points, n_replicas };
                Some(Design::SobolIndices(cube))
            }
            _ => None,
        }
    }
}
