//! Complete runs and rejected scenes, as integration tests: a unit test that runs one would compile its solver again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod building;
#[path = "../../../result-pages/tests/drive/mod.rs"]
mod drive;
mod established;
mod fpk;
mod harness;
mod long_runs;
mod mistakes;
mod peridyn;
mod run_page;
mod smpm;
mod smpm_bodies;
mod smpm_fields;
mod smpm_sweep;
mod sources;
