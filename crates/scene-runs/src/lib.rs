#![doc = include_str!("../README.md")]

pub mod checkpoint;
mod choice;
pub mod kind;
mod process;
mod results;
pub mod scene;
pub mod schema;

pub use self::answers::{Answer, Answers};
pub use self::choice::{advise, ladder, models};
pub use self::kind::{
    BlockRecord, Cut, EnsemblePart, Finished, Found, Inputs, JobRecord, Options, Place, Progress,
    Run, RunError, SceneKind, SolverError, check, kind_of, run, run_on_ranks,
};
pub use self::process::{causes, clock, interrupt, machine, nearest};
pub(crate) use self::results::page;
pub use self::results::{answers, output, report, result_file};
pub use self::scene::SceneFile;
