//! Guided or free paths in blocks that any process may compute.

use std::ops::Range;

use random_vibration::{PathBlock, TailError};
use scene_runs::kind::{Computed, Ensemble, Inputs, Items, Run, RunError};
use serde::Serialize;

/// Blocks for each thread between two looks at the checkpoint.
const BLOCKS_OF_THREAD: u64 = 4;

/// Computes blocks of paths, or the part of them that a run is asked for.
pub(crate) fn path_blocks(
    run: &Run<'_>,
    inputs: &Inputs<'_, impl Serialize>,
    n_blocks: u64,
    compute: &(dyn Fn(Range<u64>) -> Result<Vec<PathBlock>, TailError> + Sync),
) -> Result<Computed<Items<PathBlock>>, RunError> {
    let ensemble = Ensemble {
        what: "blocks of paths",
        n: n_blocks,
        n_on_ranks: n_blocks,
        at_once: BLOCKS_OF_THREAD * rayon::current_num_threads() as u64,
        compute: &|blocks, _| compute(blocks).map_err(RunError::solver),
        words: &|_| "blocks of paths".to_owned(),
    };
    run.ensemble(inputs, &ensemble)
}
