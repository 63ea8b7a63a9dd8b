//! Many cracks of one body: realisations side by side, in shards.

mod crack_run;
mod ended;
mod equilibria;
mod fate;
mod group;
mod halted;
mod inputs;
mod run;
mod shard;
mod study;

pub use crack_run::{BrokenInStep, CrackRun, FinalState};
pub use halted::{GroupProgress, HaltedRun, RunOutcome};
pub use shard::{CrackShard, merge_shards};
pub use study::{BondOrder, CrackStudy, Procedure, Stiffness, Strength, StudyLaw};
