//! What the method must keep, the limits that are known in closed form, and the extension traits: in one program, since the
//! step is compiled anew for every one.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

mod conditioned;
mod custom_estimator;
mod custom_system;
mod first_passage;
mod fixtures;
mod flow_map;
mod limits;
mod method;
mod moment_balance;
mod observables;
mod reach;
mod remapping;
mod time_schemes;
mod tolerance;
