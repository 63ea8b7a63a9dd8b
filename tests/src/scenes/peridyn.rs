//! Runs a scene of cracks: the law of the path, of its length and exit, and of the load, each with its error.

mod fields;
mod pictures;
mod record;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use peridyn_sde::statistics::{Bootstrap, CrackEnsemble};
use sde_integrators::Noise;

use self::record::{Record, RunResult, WorkRecord};
use crate::case::Context;
use crate::machine::{Machine, commit};
use crate::output::write_json;
use crate::peridyn::scene::CrackScene;
use crate::peridyn::scene_problem::CrackProblem;
use crate::scene::SceneFile;
use crate::scenes::{RunError, SceneKind};

pub(crate) const KIND: SceneKind =
    SceneKind { solver: "peridyn-sde", schema: || schemars::schema_for!(CrackScene), run };

fn run(file: &SceneFile, out: &Path, context: &Context<'_>) -> Result<Vec<PathBuf>, RunError> {
    let scene: CrackScene = file.parse()?;
    let problem =
        CrackProblem::new(&scene, file.folder()).map_err(|objection| file.object_to(&objection))?;
    let clock = cpu_time::ProcessTime::now();
    let n_realisations = scene.ensemble.realisations;
    let ended = AtomicU64::new(0);
    let finished = |more: u64| {
        let ended = ended.fetch_add(more, Ordering::Relaxed) + more;
        context.progress(&format!("{ended} of {n_realisations} realisations"));
    };
    context.progress(&format!("{n_realisations} realisations"));
    let run = problem.run(&scene, &finished).map_err(RunError::solver)?;
    let cpu_seconds = clock.elapsed().as_secs_f64();
    let ensemble = CrackEnsemble::new(n_realisations, run.records.iter().cloned())
        .map_err(RunError::solver)?;
    let bootstrap = Bootstrap::new(Noise::new(scene.ensemble.seed));
    let record = Record::new(&scene, &problem, &run, &ensemble, &bootstrap)?;
    for unknown in &record.unknown {
        context.progress(&format!("unknown: {}: {}", unknown.what, unknown.reason));
    }
    let drawings = pictures::drawings(&scene, &problem, &run, &ensemble, &record, &bootstrap)?;
    let result = RunResult {
        schema: "crack-ensemble/1",
        version: env!("CARGO_PKG_VERSION"),
        commit: commit(),
        machine: Machine::read(),
        scene: &scene,
        resolved: &problem.resolved,
        seed: scene.ensemble.seed,
        work: WorkRecord::new(&scene, &problem.resolved, cpu_seconds),
        record: &record,
    };
    let path = out.join("result.json");
    write_json(&path, &result)?;
    let mut written = vec![path];
    for drawing in drawings {
        written.push(drawing.write(out).map_err(RunError::solver)?);
    }
    written.extend(fields::write(&scene, &problem, &run, out).map_err(RunError::Solver)?);
    Ok(written)
}
