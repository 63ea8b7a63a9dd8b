#![doc = include_str!("../README.md")]

pub mod advise;
pub mod answers;
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
pub mod report;
pub mod result_file;
pub mod scene;
pub mod schema;
#[cfg(feature = "smpm")]
pub mod smpm;
mod solve;
pub mod sources;

pub use self::answers::{Answer, Answers};
pub use self::built_in::ALL;
pub use self::kind::{
    BlockRecord, Cut, Finished, Found, Inputs, JobRecord, Options, Part, Place, Progress, Run,
    RunError, SceneKind, SolverError, check, kind_of, run, run_on_ranks,
};
pub use self::scene::SceneFile;
pub use self::solve::solve;
