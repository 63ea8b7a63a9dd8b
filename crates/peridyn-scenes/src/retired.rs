//! Names that scenes had once, each with its successor. Add a line for each variant or key that is removed.

use scene_runs::scene::Retired;

pub(crate) const RETIRED: &[Retired] = &[Retired {
    path: "mobility.compact",
    successor: "`low_rank`, which serves any correlation length",
}];
