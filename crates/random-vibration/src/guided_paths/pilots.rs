//! The strength of a guide, chosen by pilot paths.

use sde_integrators::{Guide, GuidedPath, Passages, reduce_in_tree};

use crate::guided_paths::event::Event;
use crate::guided_paths::guided_config::GuidedConfig;
use crate::guided_paths::path_runner::{PathBlock, PathRunner, PathSet, n_blocks};
use crate::guided_paths::weights::{Contributions, merge_sums};
use crate::tail::TailError;

/// Strengths among which the pilot paths choose: factors on the running deviations in the linearisation.
pub(crate) const STRENGTHS: [f64; 5] = [1.0, 1.5, 2.0, 2.5, 3.0];
/// The first realisation of the pilot paths: no ensemble reaches it.
const FIRST_PILOT: u64 = 1 << 63;

/// For each event the strength whose weights have the smallest second moment over the pilot paths.
///
/// `candidates` makes the guides to an event of a strength with a share.
pub(crate) fn strongest(
    runner: &PathRunner<'_>,
    candidates: &dyn Fn(usize, usize, f64) -> Vec<Guide>,
    events: &[Event<'_>],
    (n_steps, passages): (usize, Option<Passages<'_>>),
    config: &GuidedConfig,
) -> Result<Vec<usize>, TailError> {
    let n_strengths = STRENGTHS.len();
    if config.n_pilots == 0 {
        return Ok(vec![n_strengths / 2; events.len()]);
    }
    let n_groups = events.len() * n_strengths;
    let (unguided, of_group) = (config.unguided, n_groups as f64);
    let part = (1.0 - unguided) / of_group;
    let mut all = Vec::new();
    let mut places = Vec::with_capacity(n_groups);
    for group in 0..n_groups {
        let first = all.len();
        all.extend(candidates(group / n_strengths, group % n_strengths, part));
        places.push(first..all.len());
    }
    let collect = |path: &GuidedPath<'_>, sums: &mut [Contributions]| {
        for (group, (sum, place)) in sums.iter_mut().zip(&places).enumerate() {
            let Some(known) = events[group / n_strengths].known(path) else {
                sum.push(None);
                continue;
            };
            // The density of the mixture with this event and strength alone, over that of the pilots.
            let mut density = unguided;
            let ratios = &known.log_ratios[place.clone()];
            for (guide, ratio) in all[place.clone()].iter().zip(ratios) {
                density += of_group * guide.share * ratio.exp();
            }
            sum.push(Some(known.log_weight.exp() / density));
        }
    };
    let (seed, realisations) = (config.seed, (FIRST_PILOT, config.n_pilots));
    let set = PathSet { guides: &all, passages, seed, n_steps, realisations };
    let blocks = runner.collected(&set, 0..n_blocks(config.n_pilots), n_groups, &collect)?;
    let sums = reduce_in_tree(&blocks, &|block: &PathBlock| block.sums.clone(), &merge_sums);
    let best = |sums: &[Contributions]| {
        let smallest = |a: &usize, b: &usize| sums[*a].mean().total_cmp(&sums[*b].mean());
        (0..sums.len()).min_by(smallest).unwrap_or_default()
    };
    Ok(sums.unwrap_or_default().chunks_exact(n_strengths).map(best).collect())
}
