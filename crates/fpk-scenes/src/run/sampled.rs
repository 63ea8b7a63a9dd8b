//! Runs a density scene by Monte Carlo: shards in sequence, a part of them, or merged shards of other runs.

use mpi_ensembles::Ranks;
use result_figures::number::with_uncertainty;
use scene_runs::kind::{Cut, Inputs, Part, Run, RunError};
use sde_integrators::{Estimate, GaussianMixture};

use super::asked::{asked, law};
use super::observed::Observed;
use super::outcome::Outcome;
use super::record::{WorkRecord, asked_series, moment_words};
use crate::density::Asked;
use crate::monte_carlo::{self, SampledRow, SampledSoFar, Sampling, Shard};
use crate::paths::Paths;
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
/// Name of the finished shards in a checkpoint.
const SHARDS: &str = "shards";

impl Visitor for Sampled<'_> {
    type Output = Result<Outcome, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        self.sampled::<D>(&|paths, place| system.shard(paths, place))
    }
}

impl Sampled<'_> {
    /// Runs the ensemble; `shard` runs a part of it.
    fn sampled<const D: usize>(self, shard: Shard<'_, D>) -> Result<Outcome, RunError> {
        let Self { scene, system: named, ref sampling, run } = self;
        let inputs = &Inputs { scene, seed: Some(sampling.seed), files: &[] };
        let (law, asked) = (law::<D>(scene, named)?, asked::<D>(scene, named, false)?);
        let so_far = match (run.part(), run.ranks()) {
            (Part::Merged(files), _) => SampledSoFar::of(run.read_shards(inputs, files)?),
            (_, Some(ranks)) => match self.on_ranks(shard, (&law, &asked), ranks, inputs)? {
                Some(parts) => SampledSoFar::of(parts),
                None => return Ok(Outcome { is_elsewhere: true, ..Outcome::default() }),
            },
            (Part::Whole | Part::Shard(_), None) => self.here(shard, (&law, &asked), inputs)?,
        };
        if let Part::Shard(place) = run.part() {
            let files = vec![run.write_shard(inputs, *place, &so_far)?];
            return Ok(Outcome { files, is_elsewhere: true, ..Outcome::default() });
        }
        let ensemble = so_far.run(&asked)?;
        let work = WorkRecord {
            path_steps: u64::try_from(ensemble.path_steps).ok(),
            cpu_seconds: ensemble.cpu_seconds,
            ..WorkRecord::default()
        };
        let values = |pick: &dyn Fn(&SampledRow) -> &Estimate| -> Vec<Observed> {
            let observed = |row: &SampledRow| Observed::of_estimate(row.t, pick(row));
            ensemble.rows.iter().map(observed).collect()
        };
        let moment = |k: usize| values(&|row| &row.moments[k]);
        let exceedance = |k: usize| values(&|row| &row.exceedances[k]);
        let quantities = asked_series(scene, named, &moment, &exceedance);
        Ok(Outcome { work, quantities, seed: Some(sampling.seed), ..Outcome::default() })
    }

    /// Blocks sampled by the ranks of the job; `None` on ranks without the result.
    fn on_ranks<const D: usize>(
        &self,
        shard: Shard<'_, D>,
        (law, asked): (&GaussianMixture<D>, &Asked<D>),
        ranks: &dyn Ranks,
        inputs: &Inputs<'_, FpkScene>,
    ) -> Result<Option<Vec<SampledSoFar>>, RunError> {
        let Self { scene, system: named, sampling, run } = self;
        let blocks = Cut { n: sampling.paths, unit: PATHS_OF_BLOCK };
        let n = blocks.n_blocks();
        let compute = |block: u64| {
            let (shards, none) = ((block..block + 1, n), SampledSoFar::default());
            monte_carlo::sample(shard, law, sampling, asked, shards, none, &mut |_| Ok(()))
        };
        let tell = |parts: &mut dyn Iterator<Item = &SampledSoFar>| {
            words(scene, named, asked, &SampledSoFar::of(parts.cloned()))
        };
        run.on_ranks(ranks, inputs, n, &compute, &tell)
    }

    /// Runs the shards of this process in sequence, including those of a checkpoint.
    fn here<const D: usize>(
        &self,
        shard: Shard<'_, D>,
        (law, asked): (&GaussianMixture<D>, &Asked<D>),
        inputs: &Inputs<'_, FpkScene>,
    ) -> Result<SampledSoFar, RunError> {
        let Self { scene, system: named, sampling, run } = self;
        let checkpoint = run.checkpoint(inputs, &["/title"])?;
        let past = checkpoint.part::<SampledSoFar>(SHARDS)?.unwrap_or_default();
        // A separate shard is a whole number of the shards that are run in sequence.
        let parts = match run.part() {
            Part::Shard(place) => place.n_shards(),
            Part::Whole | Part::Merged(_) => 1,
        };
        let each = sampling.paths.div_ceil(PATHS_OF_SHARD).div_ceil(parts);
        let (range, n_shards) = (run.range(each * parts), each * parts);
        let n = range.end - range.start;
        let shards = (range, n_shards);
        let pace = run.pace("paths");
        pace.at(past.n_shards() as f64 / n as f64)?;
        monte_carlo::sample(shard, law, sampling, asked, shards, past, &mut |so_far| {
            let n_done = so_far.n_shards();
            run.progress.at((n_done, n), || words(scene, named, asked, so_far));
            let allowed = pace.at(n_done as f64 / n as f64);
            if n_done == n || allowed.is_err() || checkpoint.is_due() {
                checkpoint.keep(SHARDS, so_far)?;
            }
            Ok(allowed?)
        })
    }
}

/// Current estimate of the first moment of the scene, or else of the first exceedance, at the last time.
fn words<const D: usize>(
    scene: &FpkScene,
    system: &System,
    asked: &Asked<D>,
    so_far: &SampledSoFar,
) -> String {
    let present = so_far.present(asked).ok().and_then(|mut run| run.rows.pop());
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
