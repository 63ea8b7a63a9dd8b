//! What is read of a run: gauges, windows, the steps of a run to be repeated, snapshots.
//!
//! Nothing here changes a state, except a restored snapshot.

pub(crate) mod balance;
pub(crate) mod external;
pub(crate) mod gathered;
pub(crate) mod interpolation;
pub(crate) mod observation;
pub(crate) mod snapshot;
pub(crate) mod tearing;
