//! Why a scene was not solved.

use scene_runs::kind::RunError;
use scene_runs::scene::Objection;
use smpm::Error;

/// Error of a scene.
#[derive(Debug)]
pub(super) enum SolveError {
    /// The solver rejected its input or stopped.
    Solver(Error),
    /// Error outside the solver.
    Run(RunError),
    /// A key of the scene.
    Scene(Objection),
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

impl From<Error> for SolveError {
    fn from(error: Error) -> Self {
        Self::Solver(error)
    }
}

impl From<Objection> for SolveError {
    fn from(objection: Objection) -> Self {
        Self::Scene(objection)
    }
}

impl From<RunError> for SolveError {
    fn from(error: RunError) -> Self {
        Self::Run(error)
    }
}
