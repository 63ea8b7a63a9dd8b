#![doc = include_str!("../README.md")]

mod cloud;
mod error;
mod lattice;
mod method;
mod metric;
pub mod observables;
mod parallel;
mod refine;
mod remap;
mod report;
pub mod score;
mod simulation;
mod stage;
mod start;
mod step;
pub mod systems;

pub use cloud::{AxisNeighbours, Cloud};
pub use error::Error;
pub use method::{Combination, Estimator, InitialSmoothing, Method, Scheme, StepRule};
pub use metric::Metric;
pub use refine::{Refined, RefinedValue, Refinement, RefinementEnd, RefinementRun, refine};
pub use remap::{BEYOND_THE_CLOUD, Remapped, Remapping};
pub use report::{StepReport, Work};
pub use score::ScoreEstimator;
pub use simulation::{COLLAPSED_STEP, Config, DEFAULT_MOST_STEPS, Simulation};
pub use start::{DEFAULT_REACH, InitialLattice};
pub use step::MOST_UNRESOLVED;
