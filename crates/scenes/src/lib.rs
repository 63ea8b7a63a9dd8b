#![doc = include_str!("../README.md")]

pub mod advise;
#[cfg(feature = "fpk")]
pub mod building;
mod built_in;
pub mod causes;
pub mod checkpoint;
#[cfg(feature = "cli")]
pub mod cli;
pub mod clock;
#[cfg(feature = "peridyn")]
pub mod crack_inference;
pub mod findings;
#[cfg(feature = "fpk")]
pub mod fpk;
pub mod interrupt;
pub mod kind;
pub mod ladder;
pub mod machine;
pub mod models;
pub mod nearest;
pub mod output;
mod page;
#[cfg(feature = "fpk")]
mod path_blocks;
#[cfg(feature = "peridyn")]
pub mod peridyn;
pub mod run_result;
pub mod scene;
pub mod schema;
#[cfg(feature = "smpm")]
pub mod smpm;
mod solve;

pub use self::built_in::ALL;
pub use self::kind::{
    BlockRecord, BlocksLeft, Cut, Inputs, JobRecord, Options, PageFile, Part, Place, Progress, Run,
    RunError, SceneKind, SolverError, check, kind_of, run, run_on_ranks,
};
pub use self::ladder::{Answer, Quantity};
pub use self::scene::SceneFile;
pub use self::solve::{SolveError, solve};
