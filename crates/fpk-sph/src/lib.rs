#![doc = include_str!("../README.md")]

mod cloud;
mod coefficients;
mod config;
mod discretisation;
mod error;
mod evaluation;
mod lattice;
mod method;
mod metric;
pub mod observables;
mod parallel;
mod refine;
mod remap;
mod report;
mod runge_kutta;
pub mod score;
mod simulation;
mod snapshot;
mod solver;
mod start;
mod state;
mod step;
mod step_length;
pub mod systems;

pub use cloud::{AxisNeighbours, Cloud};
pub use config::{COLLAPSED_STEP, Config, DEFAULT_MOST_STEPS};
pub use error::Error;
pub use method::{Combination, Estimator, InitialSmoothing, Method, Scheme, StepRule};
pub use metric::Metric;
pub use refine::{Refined, RefinedValue, Refinement, RefinementEnd, RefinementRun, refine};
pub use remap::{BEYOND_THE_CLOUD, Remapped, Remapping};
pub use report::{StepReport, Work};
pub use score::ScoreEstimator;
pub use simulation::Simulation;
pub use start::{DEFAULT_REACH, InitialLattice};
pub use step::MOST_UNRESOLVED;
