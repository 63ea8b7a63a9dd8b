#![doc = include_str!("../README.md")]

pub mod advise;
pub mod answers;
pub mod causes;
pub mod checkpoint;
pub mod clock;
pub mod interrupt;
pub mod kind;
pub mod ladder;
pub mod machine;
pub mod models;
pub mod nearest;
pub mod output;
mod page;
pub mod report;
pub mod result_file;
pub mod scene;
pub mod schema;

pub use self::answers::{Answer, Answers};
pub use self::kind::{
    BlockRecord, Cut, Finished, Found, Inputs, JobRecord, Options, Part, Place, Progress, Run,
    RunError, SceneKind, SolverError, check, kind_of, run, run_on_ranks,
};
pub use self::scene::SceneFile;
