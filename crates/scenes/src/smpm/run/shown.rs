//! Frames of the particles for the page of a run.

use pages::{Frame, Layer, Motion, Place, Points, Scale};
use smpm::Quantity;

use crate::smpm::scene::{SmpmScene, UnitsScene};

/// Frames so far: positions and columns of the particles that are shown.
#[derive(Debug)]
pub(super) struct Shown {
    units: UnitsScene,
    spacing: f64,
    dimension: usize,
    /// Numbers of the frames that the page shows and that have not been seen.
    numbers: Vec<usize>,
    n_frames: usize,
    /// Bytes of a frame for each particle.
    n_layers: usize,
    /// Every how many particles one is shown, known from the first frame on.
    stride: Option<usize>,
    takes_frame: bool,
    n_particles: usize,
    frames: Vec<Frame>,
    positions: Vec<Vec<f64>>,
    layers: Vec<Layer>,
    /// Names of the quantities of the scene.
    asked: Vec<String>,
}

impl Shown {
    /// No frame yet, of `n_frames`.
    pub(super) fn new(scene: &SmpmScene, n_frames: usize) -> Self {
        let grid = &scene.grid;
        // Mean and deviation of each quantity, of pressure and of density.
        let n_layers = 2 * (scene.quantities.len() + 2);
        Self {
            units: scene.units,
            spacing: grid.cell / f64::from(grid.particles_per_cell),
            dimension: scene.dimension,
            numbers: Motion::shown_frames(n_frames, Motion::MOST_FRAMES),
            n_frames,
            n_layers,
            stride: None,
            takes_frame: false,
            n_particles: 0,
            frames: Vec::new(),
            positions: Vec::new(),
            layers: Vec::new(),
            asked: scene.quantities.iter().map(|name| name.replace('_', " ")).collect(),
        }
    }

    /// Begins a frame; its layers follow.
    pub(super) fn begin<const D: usize>(
        &mut self,
        number: usize,
        time: f64,
        positions: &[[f64; D]],
    ) {
        // A frame that is computed again is the same.
        let place = self.numbers.iter().position(|&it| it == number);
        self.takes_frame = place.is_some();
        let Some(place) = place else { return };
        self.numbers.remove(place);
        let n = positions.len();
        let n_shown = self.numbers.len() + 1;
        let stride = Motion::stride(n, n_shown, D, self.n_layers);
        let stride = *self.stride.get_or_insert(stride);
        self.n_particles = n;
        let [_, unit, ..] = self.units.names();
        self.frames.push(Frame { name: format!("t = {time} {unit}") });
        self.positions.push(positions.iter().step_by(stride).flatten().copied().collect());
    }

    /// Adds a column of the frame that was begun.
    pub(super) fn layer(&mut self, quantity: Quantity, of: &str, column: &[f64]) {
        let (true, Some(stride)) = (self.takes_frame, self.stride) else { return };
        #[expect(clippy::cast_possible_truncation, reason = "a byte is what is shown of it")]
        let values: Vec<f32> = column.iter().step_by(stride).map(|&value| value as f32).collect();
        let name = format!("{quantity}{of}").replace('_', " ");
        match self.layers.iter_mut().find(|layer| layer.name == name) {
            Some(layer) => layer.values.push(values),
            None => self.layers.push(Layer {
                name,
                unit: self.units.of(quantity).to_owned(),
                scale: Scale::Linear,
                values: vec![values],
            }),
        }
    }

    /// All frames; none if this process has seen none.
    pub(super) fn motion(self) -> Option<Motion> {
        if self.frames.is_empty() {
            return None;
        }
        let [length, ..] = self.units.names();
        let stride = self.stride.unwrap_or(1);
        let thinned = match stride {
            1 => String::new(),
            _ => format!("One in {stride} of {} particles is shown. ", self.n_particles),
        };
        let left_out = match self.n_frames - self.frames.len() {
            0 => String::new(),
            n => format!("{n} of {} times are left out; the folder fields has all.", self.n_frames),
        };
        let mut layers = self.layers;
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
            frames: self.frames,
            place: Place::Points(Points {
                spacing: self.spacing * (stride as f64).powf(1.0 / self.dimension as f64),
                positions: self.positions,
            }),
            layers,
        })
    }
}
