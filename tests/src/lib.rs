//! Cases and their claims: the proof of the workspace.
//!
//! A case is `src/cases/<name>.rs` with a `const CASE: Case`, and one line in [`cases::ALL`].
//! Printing goes to a writer that the binary hands in; files are written by [`scenes::output`] alone.

pub mod case;
pub mod cases;
pub mod claim;
mod peridyn;
pub mod report;
mod smpm;
pub mod verify;

/// The example of the front page, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct FrontPage;
