//! Many cracks of one body: realisations side by side, in ranges that may run apart.
//!
//! A study is compiled here, with the bodies and motions of both precisions, once for all programs that run it. It knows how bodies are
//! moved, broken and followed; what becomes of the records of all realisations is in `statistics`.

mod crack_run;
mod ended;
mod equilibria;
mod fate;
mod group;
mod halted;
mod inputs;
mod run;
mod study;

pub use crack_run::{BrokenInStep, CrackRun, FinalState};
pub use halted::{GroupProgress, HaltedRun, RunOutcome};
pub use study::{BondOrder, CrackStudy, Precision, Procedure, Stiffness, Strength, StudyLaw};
