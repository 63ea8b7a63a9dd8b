//! The process: CPU time, signals, the machine, errors and words for its user.
//!
//! Nothing here knows scenes.

pub mod causes;
pub mod clock;
pub mod interrupt;
pub mod machine;
pub mod nearest;
