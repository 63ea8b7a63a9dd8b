//! Realisations over time and at their end, and the damage map, for ParaView.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use particle_store::{Attribute, Handle, ParticleStore, write_pvd};
use peridyn_sde::{CrackRun, FinalState};
use scene_runs::kind::{RunError, SolverError};

use super::growth::{Growth, axis};
use crate::scene::CrackScene;
use crate::scene_problem::CrackProblem;

/// Writes the final state and a series over time for each realisation that the scene names, and a file for the ensemble; nothing
/// if it names none.
pub(super) fn write(
    scene: &CrackScene,
    problem: &CrackProblem,
    run: &CrackRun,
    out: Option<&Path>,
) -> Result<Vec<PathBuf>, RunError> {
    let Some(out) = out.filter(|_| !scene.output.vtu.is_empty()) else { return Ok(Vec::new()) };
    let growth = Growth::of(scene, problem, &run.kept.iter().collect::<Vec<_>>())?;
    files(problem, run, &growth, &out.join("fields")).map_err(RunError::Solver)
}

fn files(
    problem: &CrackProblem,
    run: &CrackRun,
    growth: &Growth,
    folder: &Path,
) -> Result<Vec<PathBuf>, SolverError> {
    std::fs::create_dir_all(folder)?;
    let mut written = Vec::new();
    for (state, damage) in run.kept.iter().zip(&growth.damage) {
        let name = format!("realisation-{:04}", state.realisation);
        let file = folder.join(format!("{name}.vtu"));
        realisation(problem, state, &file)?;
        written.push(file);
        written.push(series(problem, (&growth.times, damage), (folder, &name))?);
    }
    if run.damage.realisations().len() >= 2 {
        let file = folder.join("ensemble.vtu");
        ensemble(problem, run, &file)?;
        written.push(file);
    }
    Ok(written)
}

/// Units of the columns, as field data.
const UNITS: [(&str, &str); 7] = [
    ("unit of position", "m"),
    ("unit of displacement", "m"),
    ("unit of damage", "1 (part of the stiffness of the bonds of a node that is lost)"),
    ("unit of critical_stretch", "1"),
    ("unit of damage_probability", "1"),
    ("unit of damage_mean", "1"),
    ("unit of damage_mean_standard_error", "1"),
];

/// Writes a store with the units of its columns.
fn write_with_units(
    store: &ParticleStore<2>,
    places: Handle<[f64; 2]>,
    file: &Path,
) -> Result<(), SolverError> {
    let columns: Vec<&str> = store.columns().map(|(name, _)| name).collect();
    let has = |name: &str| name.strip_prefix("unit of ").is_some_and(|of| columns.contains(&of));
    let units: Vec<_> = UNITS.into_iter().filter(|(name, _)| has(name)).collect();
    store.write_vtu_with(places, &units, BufWriter::new(File::create(file)?))?;
    Ok(())
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
    store.set_attribute("time", Attribute::Real(axis(problem).1));
    write_with_units(&store, places, file)
}

/// Damage over time: a `.pvd` file, and a folder of the same name with the file of each time.
fn series(
    problem: &CrackProblem,
    (times, damage): (&[f64], &[Vec<f64>]),
    (folder, name): (&Path, &str),
) -> Result<PathBuf, SolverError> {
    std::fs::create_dir_all(folder.join(name))?;
    let mut frames = Vec::new();
    for (k, (&time, damage)) in times.iter().zip(damage).enumerate() {
        let frame = format!("{name}/time-{k:02}.vtu");
        let (mut store, places) = at_rest(problem)?;
        store.add("damage", damage.clone())?;
        store.set_attribute("time", Attribute::Real(time));
        write_with_units(&store, places, &folder.join(&frame))?;
        frames.push((time, frame));
    }
    let path = folder.join(format!("{name}.pvd"));
    let frames = frames.iter().map(|(time, frame)| (*time, frame.as_str()));
    write_pvd(frames, &mut BufWriter::new(File::create(&path)?))?;
    Ok(path)
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
    store.set_attribute("time", Attribute::Real(axis(problem).1));
    write_with_units(&store, places, file)
}
