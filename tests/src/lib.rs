//! Scenes, reference data, claims and charts: the proof of the workspace.
//!
//! | to add | write | and one line in |
//! |---|---|---|
//! | a case | `src/cases/<name>.rs` with a `const CASE: Case` | [`cases::ALL`] |
//! | a kind of scene | `src/scenes/<name>.rs` with a `const KIND: SceneKind` | [`scenes::ALL`] |
//! | a chart | `src/charts/<name>.rs` with a `const CHART: ChartKind` | [`charts::ALL`] |
//! | a stability map | `src/stability/<name>.rs` with a `const MAP: ChartKind` | [`charts::STABILITY`] |
//!
//! Printing goes to a writer that the binary hands in; files are written by [`output`] alone.

pub mod advise;
pub mod case;
pub mod cases;
mod causes;
pub mod chart;
pub mod charts;
pub mod checkpoint;
pub mod claim;
pub mod finite;
pub mod fpk;
pub mod ladder;
pub mod machine;
pub mod markdown;
pub mod models;
pub mod nearest;
pub mod number;
pub mod order;
pub mod output;
pub mod peridyn;
pub mod perturbation_moments;
pub mod record;
pub mod report;
pub mod scene;
pub mod scenes;
pub mod schema;
pub mod sde;
pub mod smpm;
pub mod stability;
pub mod verify;

/// The example of the front page, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct FrontPage;
