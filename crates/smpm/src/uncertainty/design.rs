//! Which parameters complete runs are sampled at.

use perturbation_moments::MonteCarlo;
use uq_estimators::{DesignedRuns, UnitCube};

use crate::error::Error;

/// Points at which complete runs are sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Design {
    /// Independent samples.
    Random(MonteCarlo),
    /// Replicas of scrambled Sobol' points; the dimension is the number of parameters that vary, the first ones.
    QuasiRandom(UnitCube),
    /// Runs for first-order and total Sobol' indices of the same parameters.
    SobolIndices(UnitCube),
}

impl Design {
    /// Number of runs.
    ///
    /// # Errors
    /// [`Error::Sampling`] for the fields of a quasi-random design.
    pub fn n_runs(&self) -> Result<u64, Error> {
        Ok(match self {
            Self::Random(judge) => judge.n_samples,
            Self::QuasiRandom(cube) => cube.runs()?.n_runs(),
            Self::SobolIndices(cube) => cube.index_runs()?.n_runs(),
        })
    }

    /// Seed of its random numbers.
    #[must_use]
    pub const fn seed(&self) -> u64 {
        match self {
            Self::Random(judge) => judge.seed,
            Self::QuasiRandom(cube) | Self::SobolIndices(cube) => cube.seed,
        }
    }

    /// The independent standard normals of any run.
    ///
    /// # Errors
    /// As [`n_runs`](Self::n_runs).
    pub(super) fn normals(&self) -> Result<Normals, Error> {
        Ok(match self {
            Self::Random(judge) => Normals::Random(*judge),
            Self::QuasiRandom(cube) => Normals::Designed(cube.runs()?, cube.dimension),
            Self::SobolIndices(cube) => Normals::Designed(cube.index_runs()?, cube.dimension),
        })
    }
}

/// Normals by the number of a run.
pub(super) enum Normals {
    Random(MonteCarlo),
    /// With the number of parameters that vary.
    Designed(DesignedRuns, usize),
}

impl Normals {
    /// Those of a run, so many; zero for the inputs beyond the dimension of a design.
    pub(super) fn of(&self, run: u64, n: usize) -> Vec<f64> {
        let mut normals = vec![0.0; n];
        match self {
            Self::Random(judge) => judge.fill_normals(run, &mut normals),
            Self::Designed(runs, dimension) => {
                runs.normals(run, &mut normals[..(*dimension).min(n)]);
            }
        }
        normals
    }
}
