//! Scenes that are run to their end, or refused: from outside, since a unit test that runs one compiles its solver a second time.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod established;
mod fpk;
mod peridyn;
mod smpm;
