//! Methods of a scene of bodies as written in its JSON file.

use perturbation_moments::MonteCarlo;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::uncertainty::Design;
use uq_estimators::{Sampling, UnitCube};

/// Method for mean and variance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Frozen { as_printed: true })]
#[schemars(example = Self::FiniteDifference { step: 0.01 })]
#[schemars(example = Self::ForwardDifference { step: 0.01 })]
#[schemars(example = Self::MonteCarlo { samples: 400, seed: 1, control: true })]
#[schemars(example = Self::QuasiMonteCarlo { points: 32, replicas: 8, seed: 1, control: true })]
#[schemars(example = Self::SobolIndices { points: 64, replicas: 8, seed: 1 })]
#[schemars(example = Self::Multilevel(MultilevelScene::example()))]
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
    /// Multilevel Monte Carlo: most complete runs on coarse grids, few on the grid of the scene, with the same parameters on both grids
    /// of a difference.
    Multilevel(MultilevelScene),
}

/// Multilevel Monte Carlo over grids whose cells double.
///
/// The finest grid is that of the scene: against it there is no bias. Grids that follow it too loosely to pay are dropped after the pilot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MultilevelScene {
    /// Standard error: of a variance, as a part of it; of a mean, as a part of its magnitude or of the standard deviation, whichever is
    /// larger (no unit).
    pub tolerance: f64,
    /// Seed of all random numbers (no unit).
    pub seed: u64,
    /// Moments that must meet the tolerance.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("default" = MomentsScene::default()), example = MomentsScene::Variance)]
    pub moments: MomentsScene,
    /// Responses that must meet it; all others have the errors that these samples give.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("default" = DecisiveScene::default()), example = DecisiveScene::LastTime)]
    pub responses: DecisiveScene,
    /// Coarsest cell: that of the grid times a power of two (length of `units`). Without this key the largest on which each box is a whole
    /// number of cells and each boundary lies on the grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = 1.0)]
    pub coarsest_cell: Option<f64>,
    /// Samples of each grid by which the numbers of samples are planned, at least 8 (no unit).
    #[serde(default = "usual_pilot", skip_serializing_if = "is_usual_pilot")]
    #[schemars(example = 32)]
    pub pilot: u64,
    /// Largest work, in complete runs on the grid of the scene; a tolerance that needs more ends in an error before they begin (no unit).
    #[serde(default = "usual_most_runs", skip_serializing_if = "is_usual_most_runs")]
    #[schemars(example = 1000)]
    pub most_runs: u64,
}

/// Moments that decide on the number of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MomentsScene {
    /// Means.
    Mean,
    /// Variances.
    Variance,
    /// Means and variances.
    #[default]
    Both,
}

/// Responses that decide on the number of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DecisiveScene {
    /// The first quantity at the first gauge at the last time.
    #[default]
    First,
    /// All quantities at all gauges at the last time: the worst decides.
    LastTime,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

const fn usual_pilot() -> u64 {
    16
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
const fn is_usual_pilot(pilot: &u64) -> bool {
    *pilot == usual_pilot()
}

const fn usual_most_runs() -> u64 {
    10_000
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
const fn is_usual_most_runs(most_runs: &u64) -> bool {
    *most_runs == usual_most_runs()
}

impl MultilevelScene {
    /// The method with the default of every other key.
    #[must_use]
    pub const fn new(tolerance: f64, seed: u64) -> Self {
        let (moments, responses) = (MomentsScene::Both, DecisiveScene::First);
        let (pilot, most_runs) = (usual_pilot(), usual_most_runs());
        Self { tolerance, seed, moments, responses, coarsest_cell: None, pilot, most_runs }
    }

    const fn example() -> Self {
        Self::new(0.02, 1)
    }
}

impl MethodScene {
    /// The seed of a method that samples.
    pub(crate) const fn seed_mut(&mut self) -> Option<&mut u64> {
        match self {
            Self::MonteCarlo { seed, .. }
            | Self::QuasiMonteCarlo { seed, .. }
            | Self::SobolIndices { seed, .. }
            | Self::Multilevel(MultilevelScene { seed, .. }) => Some(seed),
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
