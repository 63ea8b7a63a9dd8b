//! Multilevel Monte Carlo over grids of doubling cells.

use std::collections::BTreeMap;

use rayon::prelude::*;
use scene_runs::checkpoint::{Checkpoint, CheckpointError};
use scene_runs::kind::{Inputs, Run, RunError};
use scene_runs::scene::Objection;
use smpm::uncertainty::Study;
use smpm::{Error, Plan};
use uq_estimators::{
    Bias, Block, BlockId, Error as SamplingError, Multilevel, MultilevelResult, Pair, Statistic,
    Target, TargetResult, Tolerance,
};

use super::grid_level::{Grids, Level, for_coarser_grids, on_grid};
use super::multilevel_record::{MultilevelRecord, notes};
use crate::experiment::SceneExperiment;
use crate::method_scene::{DecisiveScene, MomentsScene, MultilevelScene};
use crate::run::fields::Fields;
use crate::run::kept::KeptRuns;
use crate::run::response::{GridChange, Response, Table};
use crate::run::solve::{Answer, Solved};
use crate::run::solve_error::SolveError;
use crate::scene::SmpmScene;

/// Name of the blocks of samples in a checkpoint.
const BLOCKS: &str = "blocks of samples";
/// Keys that do not affect a sample: with another of their values a run continues. Levels are among the targets of a block.
const ASIDE: [&str; 5] = [
    "/title",
    "/method/multilevel/tolerance",
    "/method/multilevel/moments",
    "/method/multilevel/responses",
    "/method/multilevel/most_runs",
];
/// Blocks per thread between two reports.
const BLOCKS_OF_THREAD: usize = 4;

/// Runs a scene by multilevel Monte Carlo.
pub(in crate::run) fn solve<const D: usize>(
    scene: &SmpmScene,
    method: &MultilevelScene,
    (experiment, plan): (&SceneExperiment<D>, &Plan<D>),
    fields: &mut Fields<'_>,
    run: &Run<'_>,
) -> Result<Solved, SolveError> {
    let inputs = Inputs { scene, seed: Some(method.seed), files: &scene.files() };
    let kept = KeptRuns::new(Some(run.checkpoint(&inputs, &ASIDE)?), run);
    let solved = solve_kept(scene, method, (experiment, plan), fields, run, &kept);
    // The study knows only that it was not kept.
    kept.into_failure().map_or(solved, |failure| Err(SolveError::Run(failure)))
}

fn solve_kept<const D: usize>(
    scene: &SmpmScene,
    method: &MultilevelScene,
    (experiment, plan): (&SceneExperiment<D>, &Plan<D>),
    fields: &mut Fields<'_>,
    run: &Run<'_>,
    kept: &KeptRuns<'_>,
) -> Result<Solved, SolveError> {
    let cells = scene.cells(method)?;
    run.progress.stage("reference run");
    let of_scene = on_grid(scene, experiment, plan, method.seed, Some(kept))?;
    let interpolated = for_coarser_grids(experiment, plan)?;
    let (coarser, _) = cells.split_at(cells.len() - 1);
    let coarse = coarser.iter().map(|&cell| scene.on_grid(cell)).collect::<Vec<_>>();
    let experiments = coarse
        .iter()
        .map(|scene| SceneExperiment::<D>::new(scene).map_err(|it| on_coarse(scene, &it.message)))
        .collect::<Result<Vec<_>, Objection>>()?;
    let mut levels = Vec::with_capacity(cells.len());
    for (scene, experiment) in coarse.iter().zip(&experiments) {
        let level = on_grid(scene, experiment, &interpolated, method.seed, None);
        levels.push(level.map_err(|error| on_coarse(scene, &error.to_string()))?);
    }
    levels.push(of_scene);
    let grids = Grids { levels, n_responses: plan.n_responses() };
    let targets = targets(scene, method, plan);
    run.progress.stage("pilot on each grid, then samples");
    let found = estimated(method, &targets, &grids, run, kept)?;
    if scene.fields && !scene.random_fields.is_empty() {
        let study = Study::new(experiment, experiment.inputs(), plan.clone())?;
        fields.of_realisation(&study, &vec![0.0; study.n_normals()], experiment)?;
    }
    let n_steps = grids.levels.last().map_or(0, |level| level.n_steps);
    let runs_of = |pair: Pair| 1 + u64::from(pair.coarse.is_some());
    let n_runs =
        found.levels.iter().map(|level| runs_of(level.pair) * level.n_samples).sum::<u64>();
    // The reference runs, the run that begins the estimate, and the pilot of a difference whose coarser grid was dropped.
    let n_others = grids.levels.len() as u64 + 1;
    let n_others = n_others + if found.coarsest > 0 { 2 * method.pilot } else { 0 };
    let record = MultilevelRecord::new(&grids, &targets, &found);
    Ok(Solved::Whole(Answer {
        responses: responses(scene, plan, (&grids, &targets), &found)?,
        n_steps,
        n_runs: n_runs + n_others,
        cpu_seconds: kept.cpu_seconds(),
        failures: Vec::new(),
        notes: notes(&grids, &targets, &found, &record),
        multilevel: Some(record),
        balance: Vec::new(),
    }))
}

fn on_coarse(scene: &SmpmScene, message: &str) -> Objection {
    let message = format!("on the grid of cell {}: {message}", scene.grid.cell);
    Objection::new("method.multilevel", message)
        .with_help("`coarsest_cell` limits the grids that are used")
}

/// Mean and variance of every response, then the probabilities of its levels.
fn targets<const D: usize>(
    scene: &SmpmScene,
    method: &MultilevelScene,
    plan: &Plan<D>,
) -> Vec<Target> {
    let last = plan.windows.len().saturating_sub(1);
    let first = plan.index(0, 0, last);
    let mut targets = Vec::new();
    for response in 0..plan.n_responses() {
        let (_, quantity, window) = plan.parts(response);
        let is_decisive = match method.responses {
            DecisiveScene::First => response == first,
            DecisiveScene::LastTime => window == last,
        };
        let tolerance = |of: MomentsScene| {
            let is_asked = method.moments == of || method.moments == MomentsScene::Both;
            if is_decisive && is_asked {
                Tolerance::Relative(method.tolerance)
            } else {
                Tolerance::Open
            }
        };
        let mut add = |statistic, tolerance| {
            targets.push(Target { response, statistic, tolerance });
        };
        add(Statistic::Mean, tolerance(MomentsScene::Mean));
        add(Statistic::Variance, tolerance(MomentsScene::Variance));
        let name = plan.quantities[quantity].to_string();
        for &threshold in scene.levels.get(&name).into_iter().flatten() {
            add(Statistic::Exceedance { threshold }, Tolerance::Open);
        }
    }
    targets
}

/// Runs all samples. Blocks that are known from a checkpoint are not run again; the plan is the same.
fn estimated(
    method: &MultilevelScene,
    targets: &[Target],
    grids: &Grids<'_>,
    run: &Run<'_>,
    kept: &KeptRuns<'_>,
) -> Result<MultilevelResult, SolveError> {
    let work_of_run = grids.levels.last().map_or(0.0, Level::work);
    let study = Multilevel {
        name: "scene",
        targets,
        bias: Bias::FinestIsExact,
        block_length: 1,
        pilot_blocks: method.pilot,
        budget: method.most_runs as f64 * work_of_run,
    };
    let refused = |error: SamplingError| match error {
        SamplingError::OverBudget { value, .. } => over_budget(value / work_of_run, method).into(),
        error => SolveError::Solver(Error::from(error)),
    };
    let mut known = known_blocks(kept.checkpoint)?;
    let mut progress = study.begin(grids).map_err(refused)?;
    let (mut n_done, pace) = (0, run.pace("samples of the plan"));
    pace.at(0.0).map_err(RunError::from)?;
    while study.advance(grids, &mut progress).map_err(refused)? {
        let missing = progress.missing();
        for batch in missing.chunks(BLOCKS_OF_THREAD * rayon::current_num_threads()) {
            let block = |id: &BlockId| match known.get(id) {
                Some(block) => Ok(block.clone()),
                None => study.block(grids, &progress, *id),
            };
            let blocks: Vec<_> = batch.par_iter().map(block).collect();
            for block in blocks {
                let block = block.map_err(Error::from)?;
                known.insert(block.id(), block.clone());
                progress.insert(block).map_err(Error::from)?;
            }
            n_done += batch.len();
            let n_planned = n_done + progress.missing().len();
            run.progress.at((n_done as u64, n_planned as u64), || "blocks of samples".to_owned());
            let allowed = pace.at(n_done as f64 / n_planned as f64);
            keep(kept.checkpoint, &known, n_done == n_planned || allowed.is_err())?;
            allowed.map_err(RunError::from)?;
        }
    }
    Ok(study.finish(grids, &progress).map_err(Error::from)?)
}

fn known_blocks(checkpoint: Option<&Checkpoint>) -> Result<BTreeMap<BlockId, Block>, RunError> {
    let blocks: Option<Vec<Block>> = checkpoint.map_or(Ok(None), |it| it.part(BLOCKS))?;
    Ok(blocks.into_iter().flatten().map(|block| (block.id(), block)).collect())
}

fn keep(
    checkpoint: Option<&Checkpoint>,
    known: &BTreeMap<BlockId, Block>,
    is_end: bool,
) -> Result<(), RunError> {
    let keep = |it: &Checkpoint| -> Result<(), CheckpointError> {
        if is_end || it.is_due() {
            it.keep(BLOCKS, &known.values().collect::<Vec<_>>())?;
        }
        Ok(())
    };
    Ok(checkpoint.map_or(Ok(()), keep)?)
}

fn over_budget(runs: f64, method: &MultilevelScene) -> Objection {
    let message = format!(
        "the tolerance needs the work of {:.0} runs on the grid of the scene, by the samples so far; at most {} are allowed",
        runs.ceil(),
        method.most_runs
    );
    Objection::new("method.multilevel.most_runs", message)
        .with_help("allow more runs, or take a larger `tolerance` or fewer decisive responses")
}

/// The responses with their moments, from the results of all targets.
fn responses<const D: usize>(
    scene: &SmpmScene,
    plan: &Plan<D>,
    (grids, targets): (&Grids<'_>, &[Target]),
    found: &MultilevelResult,
) -> Result<Vec<Response>, Error> {
    let centre = grids.levels.last().map_or(&[][..], |level| level.centre.as_slice());
    let table = Table { scene, plan, centre };
    let of_grid = found.levels.last().filter(|_| found.pays());
    let coarser = grids.levels.len().checked_sub(2).map(|level| grids.levels[level].cell);
    let mut at = targets.iter().zip(&found.targets).enumerate().peekable();
    table.each(|i, response| {
        let mut of_response: Vec<(usize, &TargetResult)> = Vec::new();
        while let Some((place, (_, result))) = at.next_if(|(_, (target, _))| target.response == i) {
            of_response.push((place, result));
        }
        let [(place, mean), (_, variance), chances @ ..] = of_response.as_slice() else {
            return Ok(response);
        };
        let (mean, variance) = (&mean.estimate, &variance.estimate);
        let chances = chances.iter().map(|(_, chance)| Ok(chance.estimate));
        let chances = ("differences", chances);
        let mut response = table.estimated(i, response, (mean, variance), chances)?;
        let change = of_grid
            .zip(coarser)
            .map(|(level, cell)| GridChange::new(cell, &level.differences[*place]));
        response.change_from_coarser_grid = change;
        Ok(response)
    })
}
