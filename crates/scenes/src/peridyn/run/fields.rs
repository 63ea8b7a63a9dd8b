//! Final states of realisations and the damage map, for ParaView.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use particle_store::{Attribute, Handle, ParticleStore};
use peridyn_sde::{CrackRun, FinalState};

use crate::kind::SolverError;
use crate::peridyn::scene::CrackScene;
use crate::peridyn::scene_problem::CrackProblem;

/// Writes a file for each realisation that the scene names and one for the ensemble; nothing if it names none.
pub(super) fn write(
    scene: &CrackScene,
    problem: &CrackProblem,
    run: &CrackRun,
    out: &Path,
) -> Result<Vec<PathBuf>, SolverError> {
    if scene.output.vtu.is_empty() {
        return Ok(Vec::new());
    }
    let folder = out.join("fields");
    std::fs::create_dir_all(&folder)?;
    let mut written = Vec::new();
    for state in &run.kept {
        let file = folder.join(format!("realisation-{:04}.vtu", state.realisation));
        realisation(problem, state, &file)?;
        written.push(file);
    }
    if run.damage.realisations().len() >= 2 {
        let file = folder.join("ensemble.vtu");
        ensemble(problem, run, &file)?;
        written.push(file);
    }
    Ok(written)
}

/// Nodes at their initial positions.
fn at_rest(problem: &CrackProblem) -> Result<(ParticleStore<2>, Handle<[f64; 2]>), SolverError> {
    let positions = problem.nodes().positions();
    let mut store = ParticleStore::<2>::new(positions.len());
    let places = store.add("position", positions.to_vec())?;
    Ok((store, places))
}

fn realisation(problem: &CrackProblem, state: &FinalState, file: &Path) -> Result<(), SolverError> {
    let (mut store, places) = at_rest(problem)?;
    store.add("displacement", state.displacements.clone())?;
    store.add("damage", state.damage.clone())?;
    if let Some(strength) = &state.strength {
        store.add("critical_stretch", strength.clone())?;
    }
    store.set_attribute("time", Attribute::Real(problem.resolved.duration));
    store.write_vtu(places, BufWriter::new(File::create(file)?))?;
    Ok(())
}

fn ensemble(problem: &CrackProblem, run: &CrackRun, file: &Path) -> Result<(), SolverError> {
    let (mut store, places) = at_rest(problem)?;
    let probability = run.damage.probability()?;
    let mean = run.damage.mean()?;
    let values = |estimates: &[sde_integrators::Estimate]| -> Vec<f64> {
        estimates.iter().map(|estimate| estimate.value).collect()
    };
    let errors = mean.iter().map(|estimate| estimate.standard_error().unwrap_or(0.0)).collect();
    store.add("damage_probability", values(&probability))?;
    store.add("damage_mean", values(&mean))?;
    store.add::<f64>("damage_mean_standard_error", errors)?;
    store.set_attribute("time", Attribute::Real(problem.resolved.duration));
    store.write_vtu(places, BufWriter::new(File::create(file)?))?;
    Ok(())
}
