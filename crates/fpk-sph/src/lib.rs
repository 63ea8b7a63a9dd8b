#![doc = include_str!("../README.md")]

mod cloud;
mod compiled;
mod conditional_step;
mod conditioned;
mod density;
mod error;
mod extremes;
mod method;
pub mod observables;
mod parallel;
mod refine;
mod remap;
mod scheme;
pub mod score;
mod simulation;
mod solver;
mod step;
mod system;
mod time;

pub use cloud::metric::Metric;
pub use cloud::reach::{MOST_OUTSIDE, ball_reach, box_reach};
pub use cloud::start::{DEFAULT_REACH, InitialLattice};
pub use cloud::{AxisNeighbours, Cloud};
pub use conditioned::ConditionedSimulation;
pub use error::Error;
pub use method::config::{COLLAPSED_STEP, Config, DEFAULT_MOST_STEPS};
pub use method::remapping::{BEYOND_THE_CLOUD, Remapped, Remapping};
pub use method::{Combination, Estimator, MOST_NEGLIGIBLE, Method, StepRule};
pub use refine::{Refined, RefinedValue, Refinement, RefinementEnd, RefinementRun, refine};
pub use scheme::Scheme;
pub use score::ScoreEstimator;
pub use score::settling::Settling;
/// What a system of one's own and its start are written in, from [`sde_integrators`].
pub use sde_integrators::{Additive, GaussianMixture, General, Sde, SecondOrder};
pub use simulation::Simulation;
pub use solver::moment_balance::{Correction, MeanAndCovariance};
pub use solver::report::{StepReport, Work};
pub use step::MOST_UNRESOLVED;
