//! Samples of a scene: computed, from a checkpoint, from shards, or from blocks of ranks.

use std::collections::BTreeMap;
use std::path::PathBuf;

use result_figures::number::with_uncertainty;
use scene_runs::checkpoint::{Checkpoint, CheckpointError};
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Cut, EnsemblePart, Inputs, Run, RunError};
use sde_integrators::Accumulator;
use smpm::Plan;
use smpm::uncertainty::{Design, Sampled, Study};

use super::kept::KeptRuns;
use super::solve_error::SolveError;
use crate::experiment::SceneExperiment;
use crate::scene::SmpmScene;

/// Name of the samples in a checkpoint.
const SAMPLES: &str = "samples";
/// Keys that do not affect samples.
///
/// More points of a quasi-random design continue it.
pub(super) const ASIDE_OF_SAMPLES: [&str; 5] = [
    "/title",
    "/levels",
    "/method/monte_carlo/samples",
    "/method/quasi_monte_carlo/points",
    "/method/sobol_indices/points",
];
/// Samples per block of a rank.
const SAMPLES_OF_BLOCK: u64 = 4;
/// Samples per thread between two reports.
const SAMPLES_OF_THREAD: usize = 4;

/// Samples of all shards, if shard files are merged.
pub(super) fn shards<const D: usize>(
    scene: &SmpmScene,
    plan: &Plan<D>,
    run: &Run<'_>,
) -> Result<Option<Responses>, RunError> {
    let Some(design) = scene.design() else { return Ok(None) };
    let inputs = &Inputs { scene, seed: Some(design.seed()), files: &scene.files() };
    let Some(shards) = run.shards::<Responses>(inputs)? else { return Ok(None) };
    let samples: Responses = shards.into_iter().flatten().collect();
    for responses in samples.values() {
        Run::require("responses", responses.len(), plan.n_responses())?;
    }
    Ok(Some(samples))
}

/// Result of the requested samples.
pub(super) enum Samples {
    /// All samples, and their CPU time on other ranks or in earlier processes (s).
    All(Sampled, f64),
    /// The file of a shard.
    Shard(PathBuf),
    /// Another rank holds them.
    Elsewhere,
}

/// The study whose samples are requested.
pub(super) struct Requested<'a, const D: usize> {
    pub(super) scene: &'a SmpmScene,
    pub(super) study: &'a Study<'a, SceneExperiment<D>, D>,
    pub(super) design: Design,
}

/// All requested samples: computed, from a checkpoint, from shards, or from blocks of ranks.
pub(super) fn sampled<const D: usize>(
    requested: &Requested<'_, D>,
    run: &Run<'_>,
    kept: &KeptRuns<'_>,
    shards: Option<Responses>,
) -> Result<Samples, RunError> {
    let Requested { scene, study, design } = *requested;
    let plan = study.plan();
    let inputs = &Inputs { scene, seed: Some(design.seed()), files: &scene.files() };
    let each = (SAMPLES_OF_THREAD * rayon::current_num_threads()) as u64;
    let n_runs = design.n_runs().map_err(RunError::solver)?;
    let range = run.range(n_runs);
    let none_seen = |_: &Sampled, _: u64| Ok::<(), SolveError>(());
    let joined = |known: Responses, seconds: f64| {
        let all = study.sampled_from(design, range.clone(), &known, each, none_seen);
        let all = all.map_err(SolveError::of_runs)?;
        Ok(Samples::All(all, seconds))
    };
    if let Some(shards) = shards {
        return joined(shards, 0.0);
    }
    if let Some(ranks) = run.ranks() {
        let blocks = Cut { n: n_runs, unit: SAMPLES_OF_BLOCK };
        // The clock of this process counts its own blocks.
        let is_here = ranks.rank() == 0;
        let compute = |block: u64| {
            let (clock, none) = (CpuClock::start(), Responses::new());
            let range = blocks.range(block);
            let of_block = study.sampled_from(design, range, &none, each, none_seen);
            let of_block = of_block.map_err(SolveError::of_runs)?;
            let seconds = if is_here { 0.0 } else { clock.seconds() };
            Ok((of_block.responses(), seconds))
        };
        let words = |parts: &mut dyn Iterator<Item = &(Responses, f64)>| {
            words(plan, parts.flat_map(|(responses, _)| responses.values()))
        };
        let Some(parts) = run.on_ranks(ranks, inputs, blocks.n_blocks(), &compute, &words)? else {
            return Ok(Samples::Elsewhere);
        };
        let seconds = parts.iter().map(|(_, seconds)| seconds).sum();
        return joined(parts.into_iter().flat_map(|(responses, _)| responses).collect(), seconds);
    }
    let checkpoint = match kept.checkpoint {
        Some(checkpoint) => checkpoint,
        None => run.checkpoint(inputs, &ASIDE_OF_SAMPLES)?,
    };
    let known: Responses = checkpoint.part(SAMPLES)?.unwrap_or_default();
    let n = range.end - range.start;
    let pace = run.pace("samples");
    pace.at(range.clone().filter(|sample| known.contains_key(sample)).count() as f64 / n as f64)?;
    let seen = |so_far: &Sampled, tried: u64| {
        run.progress.at((tried, n), || words(plan, so_far.responses().values()));
        let allowed = pace.at(tried as f64 / n as f64);
        if tried == n || allowed.is_err() || checkpoint.is_due() {
            keep(checkpoint, &known, so_far.responses()).map_err(RunError::from)?;
        }
        Ok::<(), SolveError>(allowed.map_err(RunError::from)?)
    };
    let sampled = study.sampled_from(design, range.clone(), &known, each, seen);
    let sampled = sampled.map_err(SolveError::of_runs)?;
    Ok(match run.part() {
        EnsemblePart::Shard(place) => {
            Samples::Shard(run.write_shard(inputs, *place, &sampled.responses())?)
        }
        EnsemblePart::Whole | EnsemblePart::Merged(_) => Samples::All(sampled, 0.0),
    })
}

/// Stores new samples next to the known ones, which may be more than the scene now requests.
fn keep(
    checkpoint: &Checkpoint,
    known: &Responses,
    so_far: Responses,
) -> Result<(), CheckpointError> {
    if so_far.keys().all(|sample| known.contains_key(sample)) {
        return Ok(());
    }
    let mut all = known.clone();
    all.extend(so_far);
    checkpoint.keep(SAMPLES, &all)
}

/// Responses by sample number.
pub(super) type Responses = BTreeMap<u64, Vec<f64>>;

/// Current mean of the last response, with its standard error.
fn words<'a, const D: usize>(plan: &Plan<D>, so_far: impl Iterator<Item = &'a Vec<f64>>) -> String {
    let last = plan.n_responses().saturating_sub(1);
    let mut values = Accumulator::default();
    for value in so_far.filter_map(|responses| responses.get(last)) {
        values.push(*value);
    }
    let Ok(mean) = values.estimate() else { return String::new() };
    let (gauge, quantity, _) = plan.parts(last);
    let mean = with_uncertainty(Some(mean.value), mean.standard_error());
    format!("{} at {}: {mean}", plan.quantities[quantity], plan.gauges[gauge].name)
}
