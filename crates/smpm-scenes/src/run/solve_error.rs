//! Why a scene was not solved.

use scene_runs::kind::RunError;
use scene_runs::scene::Objection;
use smpm::Error;

/// Error of a scene.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(super) enum SolveError {
    /// The solver rejected its input or stopped.
    Solver(#[from] Error),
    /// Error outside the solver.
    Run(#[from] RunError),
    /// A key of the scene.
    Scene(#[from] Objection),
}

impl SolveError {
    /// The error of runs, which object to no key.
    pub(super) fn of_runs(self) -> RunError {
        match self {
            Self::Solver(error) => RunError::solver(error),
            Self::Run(error) => error,
            Self::Scene(objection) => RunError::solver(objection),
        }
    }
}
