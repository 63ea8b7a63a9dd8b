//! Many paths: which run together, what is recorded of them, and the probabilities of rare events among them.
//!
//! Nothing here knows a formula of a method.

pub(crate) mod ensemble;
pub(crate) mod follow;
pub(crate) mod guide;
pub(crate) mod guided;
pub(crate) mod guided_group;
pub(crate) mod guided_watch;
pub(crate) mod maximum;
pub(crate) mod rare;
pub(crate) mod samples;
pub(crate) mod schedule;
pub(crate) mod shard;
pub(crate) mod step_halving;
pub(crate) mod tally;
