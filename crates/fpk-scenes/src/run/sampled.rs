//! Runs a density scene by Monte Carlo.

use std::ops::Range;

use result_figures::number::with_uncertainty;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Computed, Cut, Ensemble, EnsemblePart, Inputs, Items, Run, RunError};
use sde_integrators::{Estimate, GaussianMixture, ShardRecord, merge, merge_so_far};

use super::observed::Observed;
use super::record::{Content, WorkRecord, asked_series, moment_words};
use super::step_bias::StepBias;
use crate::density::Requested;
use crate::monte_carlo::{SampledRow, SampledRun, Sampling, Shard, sampled_shard};
use crate::paths::{Paths, PathsError};
use crate::scene::FpkScene;
use crate::system::{System, Visitor};

/// Sampled paths.
pub(super) struct Sampled<'a> {
    pub(super) scene: &'a FpkScene,
    pub(super) system: &'a System,
    pub(super) sampling: Sampling,
    pub(super) run: &'a Run<'a>,
}

/// Approximate number of paths per shard: every thread has several of its blocks.
const PATHS_OF_SHARD: u64 = 16 * sde_integrators::BLOCK_LENGTH;
/// Number of paths per block of a rank.
///
/// It takes a quarter of a second for the damper, long compared with the step tables made for each block.
const PATHS_OF_BLOCK: u64 = 4 * sde_integrators::BLOCK_LENGTH;

/// Why the scatter of a moment is unknown: see `Accumulator::cautious_estimate`.
const ONE_PATH_DECIDES: &str = "one path holds much of the scatter, and rarer ones decide on the mean: take more paths, or a lower moment";

/// Measures the bias of the steps; all other code is compiled once for each number of states.
type BiasOf<'a, const D: usize> = &'a dyn Fn(&GaussianMixture<D>, &Requested<D>) -> StepBias;

impl Visitor for Sampled<'_> {
    type Output = Result<Computed<Content>, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let bias = |law: &_, asked: &_| {
            StepBias::measured((system, self.system.is_linear()), law, &self.sampling, asked)
        };
        self.sampled::<D>(&|paths, place| system.shard(paths, place), &bias)
    }
}

impl Sampled<'_> {
    /// Runs the ensemble; `shard` runs a part of it.
    fn sampled<const D: usize>(
        &self,
        shard: Shard<'_, D>,
        bias: BiasOf<'_, D>,
    ) -> Result<Computed<Content>, RunError> {
        let &Self { scene, system: named, ref sampling, run } = self;
        let inputs = &Inputs { scene, seed: Some(sampling.seed), files: &[] };
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        // A separate shard is a whole number of the shards that are run in sequence.
        let parts = match run.part() {
            EnsemblePart::Shard(place) => place.n_shards(),
            EnsemblePart::Whole | EnsemblePart::Merged(_) => 1,
        };
        let compute = |shards: Range<u64>, n: u64| {
            let one = |k| sampled_shard(shard, &law, sampling, &asked, (k, n));
            Ok(shards.map(one).collect::<Result<Vec<_>, _>>()?)
        };
        let ensemble = Ensemble {
            what: "paths",
            n: sampling.paths.div_ceil(PATHS_OF_SHARD).div_ceil(parts) * parts,
            n_on_ranks: Cut { n: sampling.paths, unit: PATHS_OF_BLOCK }.n_blocks(),
            at_once: 1,
            compute: &compute,
            words: &|shards| words(scene, named, &asked, shards),
        };
        let Items { list, cpu_seconds } = match run.ensemble(inputs, &ensemble)? {
            Computed::Here(shards) => shards,
            Computed::Elsewhere(files) => return Ok(Computed::Elsewhere(files)),
        };
        let merged = merge(&list).and_then(|all| all.ensemble()).map_err(PathsError::from)?;
        let ensemble = SampledRun::of(&asked, &merged, cpu_seconds)?;
        run.progress.stage("pairs of paths with half the step, for its bias");
        let clock = CpuClock::start();
        let bias = bias(&law, &asked);
        let cpu_seconds = ensemble.cpu_seconds + clock.seconds();
        let work = WorkRecord {
            path_steps: u64::try_from(ensemble.path_steps).ok(),
            cpu_seconds,
            ..WorkRecord::default()
        };
        let values = |pick: &dyn Fn(&SampledRow) -> &Estimate| -> Vec<Observed> {
            let observed = |row: &SampledRow| Observed::of_estimate(row.t, pick(row));
            ensemble.rows.iter().map(observed).collect()
        };
        let moment = |k: usize| {
            let values = values(&|row| &row.moments[k]).into_iter();
            let mut values: Vec<_> = values.map(|it| it.unknown_for(ONE_PATH_DECIDES)).collect();
            for observed in &mut values {
                bias.add_to_moment(k, observed);
            }
            values
        };
        let exceedance = |k: usize| {
            let mut values = values(&|row| &row.exceedances[k]);
            for observed in &mut values {
                bias.add_to_probability(asked.thresholds[k], observed);
            }
            values
        };
        let quantities = asked_series(scene, named, &moment, &exceedance);
        let (seed, unknown) = (Some(sampling.seed), bias.unknown().into_iter().collect());
        let content = Content { seed, work, unknown, quantities, ..Content::default() };
        Ok(Computed::Here(content))
    }
}

/// Current estimate of the first moment of the scene, or else of the first exceedance, at the last time.
fn words<const D: usize>(
    scene: &FpkScene,
    system: &System,
    asked: &Requested<D>,
    shards: &[ShardRecord],
) -> String {
    let merged = merge_so_far(shards).and_then(|all| all.ensemble()).ok();
    let present = merged.and_then(|it| SampledRun::of(asked, &it, 0.0).ok()?.rows.pop());
    let Some(SampledRow { moments, exceedances, .. }) = present else { return String::new() };
    let told = |name: String, estimate: &Estimate| {
        let value = with_uncertainty(Some(estimate.value), estimate.standard_error());
        format!("shards of paths, {name} = {value}")
    };
    let moment = scene.moments.first().zip(moments.first());
    let exceedance = scene.thresholds.first().zip(exceedances.first());
    match (moment, exceedance) {
        (Some((powers, value)), _) => told(moment_words(powers, system.states()), value),
        (None, Some((threshold, value))) => {
            told(format!("P(|{}| > {threshold})", asked.demand.name), value)
        }
        (None, None) => "shards of paths".to_owned(),
    }
}
