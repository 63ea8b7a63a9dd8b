//! Blocks of guided or free paths: in sequence with checkpoints, as a shard, on ranks, or merged from shards.

use std::ops::Range;
use std::path::PathBuf;

use random_vibration::{PathBlock, TailError};
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Inputs, Part, Run, RunError};
use serde::{Deserialize, Serialize};

/// Name of the finished blocks in a checkpoint.
const BLOCKS: &str = "blocks of paths";
/// Blocks for each thread between two looks at the checkpoint.
const BLOCKS_OF_THREAD: u64 = 4;

/// Paths in blocks that any process may compute.
pub(crate) struct PathBlocks<'p> {
    /// Number of blocks.
    pub(crate) n_blocks: u64,
    /// Runs some of them.
    pub(crate) compute: &'p (dyn Fn(Range<u64>) -> Result<Vec<PathBlock>, TailError> + Sync),
}

/// Finished blocks in order.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Finished {
    pub(crate) blocks: Vec<PathBlock>,
    /// CPU time of the blocks (s).
    pub(crate) cpu_seconds: f64,
}

/// Blocks of a run.
pub(crate) enum Computed {
    /// All of them.
    All(Finished),
    /// Those of a shard, in its file, or of a rank without the result.
    Elsewhere(Vec<PathBuf>),
}

impl PathBlocks<'_> {
    /// Computes the blocks of this process, or collects those of others.
    pub(crate) fn run(
        &self,
        run: &Run<'_>,
        inputs: &Inputs<'_, impl Serialize>,
    ) -> Result<Computed, RunError> {
        let finished = match (run.part(), run.ranks()) {
            (Part::Merged(files), _) => Finished::of(run.read_shards(inputs, files)?),
            (_, Some(ranks)) => {
                let compute = |block: u64| self.finished(block..block + 1);
                let words = |_: &mut dyn Iterator<Item = &Finished>| "blocks of paths".to_owned();
                match run.on_ranks(ranks, inputs, self.n_blocks, &compute, &words)? {
                    Some(parts) => Finished::of(parts),
                    None => return Ok(Computed::Elsewhere(Vec::new())),
                }
            }
            (Part::Whole | Part::Shard(_), None) => self.here(run, inputs)?,
        };
        if let Part::Shard(place) = run.part() {
            return Ok(Computed::Elsewhere(vec![run.write_shard(inputs, *place, &finished)?]));
        }
        Ok(Computed::All(finished))
    }

    /// Runs the blocks of this process in sequence, after those of its checkpoint.
    fn here(
        &self,
        run: &Run<'_>,
        inputs: &Inputs<'_, impl Serialize>,
    ) -> Result<Finished, RunError> {
        let checkpoint = run.checkpoint(inputs, &["/title"])?;
        let mut finished = checkpoint.part::<Finished>(BLOCKS)?.unwrap_or_default();
        let range = run.range(self.n_blocks);
        let n = range.end - range.start;
        let at_once = BLOCKS_OF_THREAD * rayon::current_num_threads() as u64;
        let pace = run.pace("blocks of paths");
        loop {
            let done = finished.blocks.len() as u64;
            run.progress.at((done, n), || "blocks of paths".to_owned());
            if done >= n {
                return Ok(finished);
            }
            if let Err(too_long) = pace.at(done as f64 / n as f64) {
                checkpoint.keep(BLOCKS, &finished)?;
                return Err(too_long.into());
            }
            let first = range.start + done;
            let more = self.finished(first..(first + at_once).min(range.end))?;
            finished = Finished::of([finished, more]);
            if finished.blocks.len() as u64 == n || checkpoint.is_due() {
                checkpoint.keep(BLOCKS, &finished)?;
            }
        }
    }

    fn finished(&self, blocks: Range<u64>) -> Result<Finished, RunError> {
        let clock = CpuClock::start();
        let blocks = (self.compute)(blocks).map_err(RunError::solver)?;
        Ok(Finished { blocks, cpu_seconds: clock.seconds() })
    }
}

impl Finished {
    /// All blocks of some parts, in order.
    fn of(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for mut part in parts {
            all.blocks.append(&mut part.blocks);
            all.cpu_seconds += part.cpu_seconds;
        }
        all
    }
}
