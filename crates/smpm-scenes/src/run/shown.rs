//! Frames of the particles for the page of a run.

use result_pages::{Frame, Layer, Motion, Place, Points, Scale};
use serde::{Deserialize, Serialize};
use smpm::Quantity;

use crate::scene::{SmpmScene, UnitsScene};

/// Frames so far: positions and columns of the particles that are shown. A checkpoint keeps them for a resumed run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Frames {
    /// Every how many particles one is shown, known from the first frame on.
    stride: Option<usize>,
    n_particles: usize,
    times: Vec<f64>,
    positions: Vec<Vec<f64>>,
    columns: Vec<Column>,
}

/// A quantity in every frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Column {
    name: String,
    unit: String,
    values: Vec<Vec<f32>>,
}

impl Frames {
    /// Keeps the frames whose times are wanted.
    fn retain(&mut self, is_wanted: impl Fn(f64) -> bool) {
        let wanted: Vec<bool> = self.times.iter().map(|&time| is_wanted(time)).collect();
        keep(&mut self.times, &wanted);
        keep(&mut self.positions, &wanted);
        self.columns.iter_mut().for_each(|column| keep(&mut column.values, &wanted));
    }
}

/// Keeps the entries that are wanted.
fn keep<T>(entries: &mut Vec<T>, wanted: &[bool]) {
    let mut wanted = wanted.iter();
    entries.retain(|_| wanted.next().copied().unwrap_or_default());
}

/// The frames of a run.
#[derive(Debug)]
pub(super) struct Shown {
    units: UnitsScene,
    spacing: f64,
    dimension: usize,
    /// Times of the frames that the page shows and that have not been seen.
    missing: Vec<f64>,
    n_wanted: usize,
    n_frames: usize,
    /// Bytes of a frame for each particle.
    n_layers: usize,
    takes_frame: bool,
    seen: Frames,
    /// Names of the quantities of the scene.
    asked: Vec<String>,
}

impl Shown {
    /// No frame yet, of those at some times.
    pub(super) fn new(scene: &SmpmScene, times: &[f64]) -> Self {
        let numbers = Motion::shown_frames(times.len(), Motion::MOST_FRAMES);
        let missing: Vec<f64> = numbers.into_iter().map(|number| times[number]).collect();
        let grid = &scene.grid;
        // Mean and deviation of each quantity, of pressure and of density.
        let n_layers = 2 * (scene.quantities.len() + 2);
        Self {
            units: scene.units,
            spacing: grid.cell / f64::from(grid.particles_per_cell),
            dimension: scene.dimension,
            n_wanted: missing.len(),
            missing,
            n_frames: times.len(),
            n_layers,
            takes_frame: false,
            seen: Frames::default(),
            asked: scene.quantities.iter().map(|name| name.replace('_', " ")).collect(),
        }
    }

    /// Takes up the frames of an interrupted run. It may have had other times, and then shown fewer or more of the particles.
    pub(super) fn resume(&mut self, mut seen: Frames) {
        if seen.stride != Some(self.stride(seen.n_particles)) {
            return;
        }
        let missing = std::mem::take(&mut self.missing);
        let is_in = |times: &[f64], time: f64| times.iter().any(|t| t.to_bits() == time.to_bits());
        seen.retain(|time| is_in(&missing, time));
        self.missing = missing.into_iter().filter(|&time| !is_in(&seen.times, time)).collect();
        self.seen = seen;
    }

    /// The frames so far.
    pub(super) const fn seen(&self) -> &Frames {
        &self.seen
    }

    /// Every how many particles one is shown.
    fn stride(&self, n_particles: usize) -> usize {
        Motion::stride(n_particles, self.n_wanted, self.dimension, self.n_layers)
    }

    /// Begins a frame; its layers follow. Returns whether it is shown.
    pub(super) fn begin<const D: usize>(&mut self, time: f64, positions: &[[f64; D]]) -> bool {
        // A frame that is computed again is the same.
        let place = self.missing.iter().position(|it| it.to_bits() == time.to_bits());
        self.takes_frame = place.is_some();
        let Some(place) = place else { return false };
        self.missing.remove(place);
        let stride = self.stride(positions.len());
        let stride = *self.seen.stride.get_or_insert(stride);
        self.seen.n_particles = positions.len();
        self.seen.times.push(time);
        self.seen.positions.push(positions.iter().step_by(stride).flatten().copied().collect());
        true
    }

    /// Adds a column of the frame that was begun.
    pub(super) fn layer(&mut self, quantity: Quantity, of: &str, column: &[f64]) {
        let (true, Some(stride)) = (self.takes_frame, self.seen.stride) else { return };
        #[expect(clippy::cast_possible_truncation, reason = "a byte is what is shown of it")]
        let values: Vec<f32> = column.iter().step_by(stride).map(|&value| value as f32).collect();
        let name = format!("{quantity}{of}").replace('_', " ");
        if let Some(column) = self.seen.columns.iter_mut().find(|column| column.name == name) {
            column.values.push(values);
        } else {
            let unit = self.units.of(quantity).to_owned();
            self.seen.columns.push(Column { name, unit, values: vec![values] });
        }
    }

    /// All frames; none if none was seen.
    pub(super) fn motion(self) -> Option<Motion> {
        let Frames { stride, n_particles, times, positions, columns } = self.seen;
        if times.is_empty() {
            return None;
        }
        let [length, unit, ..] = self.units.names();
        let stride = stride.unwrap_or(1);
        let thinned = match stride {
            1 => String::new(),
            _ => format!("One in {stride} of {n_particles} particles is shown. "),
        };
        let left_out = match self.n_frames - times.len() {
            0 => String::new(),
            n => format!("{n} of {} times are left out; the folder fields has all.", self.n_frames),
        };
        let layer =
            |Column { name, unit, values }| Layer { name, unit, scale: Scale::Linear, values };
        let mut layers: Vec<Layer> = columns.into_iter().map(layer).collect();
        // What the scene asks for comes first.
        let place = |layer: &Layer| {
            self.asked.iter().position(|name| layer.name.starts_with(name.as_str()))
        };
        layers.sort_by_key(|layer| place(layer).unwrap_or(usize::MAX));
        Some(Motion {
            title: "Particles over time".to_owned(),
            about: format!("{thinned}{left_out}").trim().to_owned(),
            slider: "time".to_owned(),
            axes: (1..=self.dimension).map(|axis| format!("x{axis} ({length})")).collect(),
            frames: times.iter().map(|time| Frame { name: format!("t = {time} {unit}") }).collect(),
            place: Place::Points(Points {
                spacing: self.spacing * (stride as f64).powf(1.0 / self.dimension as f64),
                positions,
            }),
            layers,
        })
    }
}
