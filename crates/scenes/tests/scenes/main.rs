//! Complete runs and rejected scenes, as integration tests: a unit test that runs one would compile its solver again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod building;
mod established;
mod fpk;
mod peridyn;
mod smpm;
mod smpm_fields;
