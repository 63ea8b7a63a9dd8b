//! Results of a density scene by a method, before output.

use std::path::PathBuf;

use scene_runs::answers::Unknown;

use super::pictures::PlaneAt;
use super::record::{Series, WorkRecord};

/// Results of a scene by a method.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    pub(super) work: WorkRecord,
    pub(super) stopped: Option<fpk_sph::Error>,
    pub(super) unknown: Vec<Unknown>,
    pub(super) quantities: Vec<Series>,
    pub(super) seed: Option<u64>,
    /// Marginal densities over planes of two states.
    pub(super) planes: Vec<PlaneAt>,
    /// Files already written.
    pub(super) files: Vec<PathBuf>,
    /// The result is that of a shard, or is on another rank.
    pub(super) is_elsewhere: bool,
}
