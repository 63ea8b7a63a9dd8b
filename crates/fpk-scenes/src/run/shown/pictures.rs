//! Pictures of the cloud: marginal densities over planes, and files for ParaView.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use fpk_sph::{Config, InitialLattice, Simulation};
use particle_store::{Attribute, ParticleStore, write_pvd};
use result_figures::{Drawing, Plane, Words};
use scene_runs::kind::{RunError, SolverError};
use scene_runs::machine::Machine;
use scene_runs::output::write_to_disk;
use sde_integrators::Sde;
use serde::{Deserialize, Serialize};

use crate::density::{ObservedRun, Row};
use crate::plane_density::plane_density;
use crate::scene::FpkScene;

/// Bandwidth of a plane's density over the spacing of the lattice.
const BANDWIDTH_OVER_SPACING: f64 = 0.6;
/// Times closer than this (s) are equal.
const SAME_TIME: f64 = 1e-9;
/// Number of coordinates that ParaView shows; further states are columns.
const SHOWN: usize = 3;

impl PictureData {
    /// Drops results after a time: the run that recorded them may have been longer.
    pub(crate) fn until(mut self, last: f64) -> Self {
        self.frames.retain(|(t, _)| *t < last + SAME_TIME);
        self
    }
}

/// Observes a run and stores the pictures that its scene requests.
pub(crate) struct Pictures<'a> {
    scene: &'a FpkScene,
    states: &'a [&'static str],
    planes: Vec<[usize; 2]>,
    bandwidth: f64,
    /// Folder of the clouds; none of a run in memory.
    folder: Option<PathBuf>,
    seen: PictureData,
    failure: Option<SolverError>,
}

/// Pictures so far.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct PictureData {
    n_times: usize,
    planes: Vec<PlaneAt>,
    /// Time and file.
    frames: Vec<(f64, String)>,
}

/// The marginal density over a plane of two states at a time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PlaneAt {
    pub(crate) states: [usize; 2],
    pub(crate) t: f64,
    pub(crate) chart: Plane,
}

impl PlaneAt {
    pub(crate) fn drawing(&self) -> Result<Drawing, RunError> {
        let Words { x_label, y_label, .. } = &self.chart.words;
        let name = format!("plane-{x_label}-{y_label}-t{:.3}", self.t);
        Drawing::plane(&name, &self.chart).map_err(RunError::solver)
    }
}

impl<'a> Pictures<'a> {
    pub(crate) fn new<const D: usize>(
        scene: &'a FpkScene,
        states: &'a [&'static str],
        config: &Config<D>,
        out: Option<&Path>,
        seen: PictureData,
    ) -> Self {
        Self {
            scene,
            states,
            planes: scene.plane_states(states).unwrap_or_default(),
            bandwidth: BANDWIDTH_OVER_SPACING * spacing(&config.lattice),
            folder: out.map(|out| out.join("cloud")),
            seen,
            failure: None,
        }
    }

    /// Observes the run at a time of observation.
    pub(crate) fn look<S: Sde<D, M>, const D: usize, const M: usize>(
        &mut self,
        standing: &ObservedRun<'_, S, D, M>,
    ) {
        let (simulation, Some(row)) = (standing.simulation, standing.rows.last()) else { return };
        self.seen.n_times += 1;
        let (None, Some(folder)) = (&self.failure, self.folder.clone()) else { return };
        let seen = self
            .observe_planes(simulation, row)
            .and_then(|()| self.write_cloud(simulation, row, &folder));
        self.failure = seen.err();
    }

    /// Content for a checkpoint.
    pub(crate) const fn seen(&self) -> &PictureData {
        &self.seen
    }

    /// Returns the pictures and the files written.
    pub(crate) fn finish(self) -> Result<(Vec<PlaneAt>, Vec<PathBuf>), RunError> {
        if let Some(failure) = self.failure {
            return Err(RunError::Solver(failure));
        }
        let mut files = Vec::new();
        if let Some(folder) = self.folder.filter(|_| !self.seen.frames.is_empty()) {
            let path = folder.join("cloud.pvd");
            let frames = self.seen.frames.iter().map(|(t, name)| (*t, name.as_str()));
            let file = File::create(&path).map_err(RunError::solver)?;
            write_pvd(frames, BufWriter::new(file)).map_err(RunError::solver)?;
            files.push(path);
        }
        Ok((self.seen.planes, files))
    }

    fn observe_planes<S: Sde<D, M>, const D: usize, const M: usize>(
        &mut self,
        simulation: &Simulation<S, D, M>,
        row: &Row,
    ) -> Result<(), SolverError> {
        let wanted = |times: &[f64]| times.iter().any(|t| (t - row.t).abs() < SAME_TIME);
        if !self.scene.planes.as_ref().is_some_and(|planes| wanted(&planes.times)) {
            return Ok(());
        }
        for &plane in &self.planes {
            let [across, up] = plane.map(|state| self.states[state]);
            let (positions, masses) = (simulation.positions(), simulation.masses());
            let density = plane_density(positions, masses, plane, self.bandwidth)
                .ok_or_else(|| format!("the cloud does not span the plane of {across} and {up}"))?;
            let smoothing = format!(
                "Masses of {} particles, smoothed by a normal kernel of {:.2} standard deviations.",
                masses.len(),
                self.bandwidth
            );
            let words = Words {
                title: format!("Marginal density of {across} and {up} at t = {:.3}", row.t),
                subtitle: self.scene.title.clone(),
                x_label: across.to_owned(),
                y_label: up.to_owned(),
                caption: vec![smoothing, Machine::read().caption()],
            };
            let chart = Plane { words, x: density.x, y: density.y, values: density.values };
            self.seen.planes.push(PlaneAt { states: plane, t: row.t, chart });
        }
        Ok(())
    }

    /// Writes the particles at a time: the first three states as positions; the others, mass and density as columns.
    fn write_cloud<S: Sde<D, M>, const D: usize, const M: usize>(
        &mut self,
        simulation: &Simulation<S, D, M>,
        row: &Row,
        folder: &Path,
    ) -> Result<(), SolverError> {
        let Some(cloud) = self.scene.cloud else { return Ok(()) };
        if !self.seen.n_times.is_multiple_of(cloud.every_observations) {
            return Ok(());
        }
        let positions = simulation.positions();
        let mut store = ParticleStore::<SHOWN>::new(positions.len());
        let place = |x: &[f64; D]| std::array::from_fn(|k| x.get(k).copied().unwrap_or(0.0));
        let places: Vec<[f64; SHOWN]> = positions.iter().map(place).collect();
        let places = store.add("position", places)?;
        store.add("mass", simulation.masses().to_vec())?;
        store.add("density", simulation.density()?)?;
        for k in SHOWN..D {
            store.add(self.states[k], positions.iter().map(|x| x[k]).collect::<Vec<f64>>())?;
        }
        store.set_attribute("time", Attribute::Real(row.t));
        std::fs::create_dir_all(folder)?;
        let name = format!("cloud-{:04}.vtu", self.seen.frames.len());
        write_to_disk(&folder.join(&name), |out| store.write_vtu(places, out))?;
        self.seen.frames.push((row.t, name));
        Ok(())
    }
}

/// The spacing of a lattice in standard deviations.
fn spacing<const D: usize>(lattice: &InitialLattice<D>) -> f64 {
    let widest = |reach: f64, count: &[usize; D]| {
        count.iter().map(|&n| 2.0 * reach / (n as f64 - 1.0)).fold(0.0, f64::max)
    };
    match lattice {
        InitialLattice::Box { reach, count } => widest(*reach, count),
        InitialLattice::Ball { spacing, .. } => *spacing,
        // The paper's rectangle is 4 standard deviations wide.
        InitialLattice::Rectangle { count, .. } => widest(4.0, count),
    }
}
