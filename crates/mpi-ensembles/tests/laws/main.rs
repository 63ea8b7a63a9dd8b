//! Jobs, and ensembles as jobs.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

mod ensembles;
mod jobs;
