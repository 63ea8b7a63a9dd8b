//! Fields for ParaView: every particle with its mean and, if derivatives are propagated, its standard deviation.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use particle_store::{Attribute, ParticleStore, write_pvd};
use perturbation_moments::{Jet, Scalar};
use result_pages::Motion;
use scene_runs::checkpoint::{Checkpoint, CheckpointError};
use scene_runs::kind::SolverError;
use scene_runs::output::write_to_disk;
use smpm::uncertainty::Study;
use smpm::{Body, Error, Number, Quantity, Simulation};

use super::shown::Shown;
use crate::experiment::SceneExperiment;
use crate::scene::{SmpmScene, UnitsScene};

/// Quantities that are always written, besides those of the scene.
const ALWAYS: [Quantity; 2] = [Quantity::Pressure, Quantity::Density];

/// Name of the frames for the page in a checkpoint.
const FRAMES: &str = "frames";

/// Writes a frame at every time of a scene. Frames before a resumed state exist already, and for the page its checkpoint has them.
pub(super) struct Fields<'a> {
    checkpoint: Option<&'a Checkpoint>,
    wanted: bool,
    quantities: Vec<Quantity>,
    folder: PathBuf,
    /// Time and file of each frame.
    frames: Vec<(f64, String)>,
    are_shown: bool,
    /// Columns that are the same in each frame.
    constants: Vec<(String, Vec<f64>)>,
    failure: Option<SolverError>,
    shown: Shown,
    units: UnitsScene,
    bodies: Vec<String>,
}

impl<'a> Fields<'a> {
    /// Frames in a folder; none of a run in memory.
    pub(super) fn new(scene: &SmpmScene, times: Vec<f64>, out: Option<&Path>) -> Self {
        let mut quantities: Vec<Quantity> = ALWAYS.to_vec();
        for quantity in scene.quantities.iter().filter_map(|name| name.parse().ok()) {
            if !quantities.contains(&quantity) {
                quantities.push(quantity);
            }
        }
        let shown = Shown::new(scene, &times);
        let name = |(number, time)| (time, format!("fields-{number:04}.vtu"));
        Self {
            checkpoint: None,
            wanted: scene.fields && out.is_some(),
            quantities,
            folder: out.map_or_else(PathBuf::new, |out| out.join("fields")),
            frames: times.into_iter().enumerate().map(name).collect(),
            are_shown: false,
            constants: Vec::new(),
            failure: None,
            shown,
            units: scene.units,
            bodies: scene.bodies.iter().map(|body| body.name.clone()).collect(),
        }
    }

    /// Takes up the frames of a checkpoint, which keeps those to come.
    pub(super) fn resume(
        &mut self,
        checkpoint: Option<&'a Checkpoint>,
    ) -> Result<(), CheckpointError> {
        self.checkpoint = checkpoint;
        let seen = checkpoint.filter(|_| self.wanted).map(|it| it.part(FRAMES)).transpose()?;
        seen.flatten().into_iter().for_each(|seen| self.shown.resume(seen));
        Ok(())
    }

    /// Writes a run with derivatives as it passes a time; the first `n_random` lanes are parameters.
    pub(super) fn of_jets<const D: usize>(
        &mut self,
        time: f64,
        run: &Simulation<Jet, D>,
        n_random: usize,
    ) {
        let deviation =
            |jet: Jet| jet.first.iter().take(n_random).map(|d| d * d).sum::<f64>().sqrt();
        let mean = |jet: Jet| jet.value + 0.5 * jet.second.iter().take(n_random).sum::<f64>();
        self.frame(time, run, mean, Some(&deviation));
    }

    /// A run at these standard normals, in `f64`, with the constants that vary in space.
    pub(super) fn of_realisation<const D: usize>(
        &mut self,
        study: &Study<'_, SceneExperiment<D>, D>,
        normals: &[f64],
        experiment: &SceneExperiment<D>,
    ) -> Result<(), Error> {
        if self.wanted {
            self.constants = experiment.constants(normals);
            study.run_seen(normals, |time, run| self.frame(time, run, |value| value, None))?;
        }
        self.are_shown();
        Ok(())
    }

    /// Marks all frames as written.
    pub(super) const fn are_shown(&mut self) {
        self.are_shown = true;
    }

    fn frame<S: Number, const D: usize>(
        &mut self,
        time: f64,
        run: &Simulation<S, D>,
        mean: impl Fn(S) -> f64,
        deviation: Option<&dyn Fn(S) -> f64>,
    ) {
        if !self.wanted || self.failure.is_some() {
            return;
        }
        let is_it = |(of, _): &(f64, String)| of.to_bits() == time.to_bits();
        let Some(number) = self.frames.iter().position(is_it) else { return };
        let name = self.frames[number].1.clone();
        let written = std::fs::create_dir_all(&self.folder)
            .map_err(SolverError::from)
            .and_then(|()| self.write(&name, time, run, mean, deviation));
        self.failure = written.err();
    }

    fn write<S: Number, const D: usize>(
        &mut self,
        name: &str,
        time: f64,
        run: &Simulation<S, D>,
        mean: impl Fn(S) -> f64,
        deviation: Option<&dyn Fn(S) -> f64>,
    ) -> Result<(), SolverError> {
        let bodies = run.bodies();
        let n_particles = bodies.iter().map(Body::n_particles).sum();
        let mut store = ParticleStore::<D>::new(n_particles);
        let places = bodies.iter().flat_map(Body::positions);
        let places: Vec<[f64; D]> = places.map(|x| x.map(Scalar::value)).collect();
        let is_shown = self.shown.begin(time, &places);
        let places = store.add("position", places)?;
        let numbers = (0_i64..).zip(bodies);
        let body = numbers.flat_map(|(b, body)| std::iter::repeat_n(b, body.n_particles()));
        store.add("body", body.collect::<Vec<i64>>())?;
        for &quantity in &self.quantities {
            let mut values = Vec::with_capacity(n_particles);
            for body in bodies {
                for particle in 0..body.n_particles() {
                    values.push(quantity.of(body, particle)?);
                }
            }
            // One realisation has no mean.
            let of = if self.constants.is_empty() { "_mean" } else { "" };
            let column: Vec<f64> = values.iter().map(|&v| mean(v)).collect();
            self.shown.layer(quantity, of, &column);
            store.add(&format!("{quantity}{of}"), column)?;
            if let Some(deviation) = deviation {
                let column: Vec<f64> = values.iter().map(|&v| deviation(v)).collect();
                self.shown.layer(quantity, "_standard_deviation", &column);
                store.add(&format!("{quantity}_standard_deviation"), column)?;
            }
        }
        for (name, column) in &self.constants {
            store.add(name, column.clone())?;
        }
        if let Some(checkpoint) = self.checkpoint.filter(|_| is_shown) {
            checkpoint.put(FRAMES, self.shown.seen())?;
        }
        store.set_attribute("time", Attribute::Real(time));
        let texts = self.texts();
        let texts: Vec<(&str, &str)> =
            texts.iter().map(|(name, text)| (&**name, &**text)).collect();
        write_to_disk(&self.folder.join(name), |out| store.write_vtu_with(places, &texts, out))?;
        Ok(())
    }

    /// Names of the bodies by their numbers, and units of the columns.
    fn texts(&self) -> Vec<(String, String)> {
        let bodies = self.bodies.iter().enumerate();
        let bodies = bodies.map(|(number, name)| (format!("body {number}"), name.clone()));
        let [length, ..] = self.units.names();
        let position = ("unit of position".to_owned(), length.to_owned());
        let quantities = self
            .quantities
            .iter()
            .map(|&quantity| (format!("unit of {quantity}"), self.units.of(quantity).to_owned()));
        bodies.chain([position]).chain(quantities).collect()
    }

    /// Files written, the series first, and the frames for the page.
    pub(super) fn finish(self) -> Result<(Vec<PathBuf>, Option<Motion>), SolverError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if !(self.wanted && self.are_shown) || self.frames.is_empty() {
            return Ok((Vec::new(), None));
        }
        let files: Vec<PathBuf> =
            self.frames.iter().map(|(_, name)| self.folder.join(name)).collect();
        if let Some(missing) = files.iter().find(|file| !file.exists()) {
            let words = "is missing; the resumed run wrote it";
            return Err(format!(
                "{} {words}: --overwrite starts from the beginning",
                missing.display()
            )
            .into());
        }
        let path = self.folder.join("fields.pvd");
        let frames = self.frames.iter().map(|(time, name)| (*time, name.as_str()));
        write_pvd(frames, &mut BufWriter::new(File::create(&path)?))?;
        Ok(([vec![path], files].concat(), self.shown.motion()))
    }
}
