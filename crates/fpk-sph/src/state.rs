//! The state of a simulation: what a step changes.

use crate::cloud::AxisNeighbours;
use crate::error::Error;
use crate::metric::{Metric, Whitening};
use crate::score::{determinant, lattice_jacobian};

/// What a step changes; all that a snapshot must hold.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State<const D: usize> {
    pub(crate) time: f64,
    pub(crate) n_steps: u64,
    pub(crate) n_remaps: u64,
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) masses: Vec<f64>,
    /// `h_i`, in the coordinates of the metric.
    pub(crate) smoothing_lengths: Vec<f64>,
    /// `h_0i / V_0i^(1/D)`, the product that eq 20 keeps.
    pub(crate) smoothing_ratios: Vec<f64>,
    /// What a scheme of two steps remembers; none before its first.
    pub(crate) previous: Option<Previous<D>>,
}

/// Memory of a scheme of two steps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Previous<const D: usize> {
    /// Positions (leap-frog), or rates without the linear part (Adams-Bashforth), one step ago.
    pub(crate) values: Vec<[f64; D]>,
    /// The step from there to the present state.
    pub(crate) dt: f64,
}

/// All coordinates, each with the number of its point.
fn coordinates<const D: usize>(points: &[[f64; D]]) -> impl Iterator<Item = (usize, f64)> {
    points.iter().enumerate().flat_map(|(i, point)| point.iter().map(move |&value| (i, value)))
}

fn remember<const D: usize>(memory: &mut Option<Previous<D>>, values: &[[f64; D]], dt: f64) {
    match memory {
        Some(previous) => {
            previous.values.copy_from_slice(values);
            previous.dt = dt;
        }
        None => *memory = Some(Previous { values: values.to_vec(), dt }),
    }
}

impl<const D: usize> State<D> {
    /// Whether numbers out of a snapshot are such as a simulation has.
    pub(crate) fn check_restored(&self, places: &[[f64; D]]) -> Result<(), Error> {
        let fits = |quantity, particle, value: f64, is_right: bool, must| {
            let error = Error::SnapshotNumber { quantity, particle, value, must };
            if is_right { Ok(()) } else { Err(error) }
        };
        fits("time", 0, self.time, self.time.is_finite(), "finite")?;
        for (i, &mass) in self.masses.iter().enumerate() {
            fits("mass", i, mass, mass.is_finite(), "finite")?;
        }
        let before = self.previous.as_ref().map_or(&[][..], |previous| &previous.values);
        for (quantity, points) in
            [("position", &self.positions[..]), ("position or rate one step ago", before)]
        {
            for (i, value) in coordinates(points) {
                fits(quantity, i, value, value.is_finite(), "finite")?;
            }
        }
        for (i, value) in coordinates(places) {
            // No place is as far out as where indices end.
            let is_right = value.fract() == 0.0 && value.abs() < f64::from(i32::MAX);
            fits("place", i, value, is_right, "a whole number of 31 bits")?;
        }
        let dt = self.previous.as_ref().map_or(1.0, |previous| previous.dt);
        fits("previous_dt", 0, dt, dt > 0.0 && dt.is_finite(), "above 0 and finite")
    }

    /// Keeps rates for the step after one of length `dt`.
    pub(crate) fn remember_rates(&mut self, rates: &[[f64; D]], dt: f64) {
        remember(&mut self.previous, rates, dt);
    }

    /// Keeps the present positions for the step after one of length `dt`.
    pub(crate) fn remember_positions(&mut self, dt: f64) {
        remember(&mut self.previous, &self.positions, dt);
    }

    /// Smoothing lengths in whitened coordinates from the deformed lattice.
    pub(crate) fn whitened_smoothing_lengths(
        &mut self,
        lattice: &[AxisNeighbours<D>],
        ratio: f64,
    ) -> Result<(), Error> {
        let at = (self.n_steps, self.time);
        let whitening = Whitening::of(Metric::Whitened, &self.positions, &self.masses, at)?;
        for (i, h) in self.smoothing_lengths.iter_mut().enumerate() {
            let edges = lattice_jacobian(&self.positions, lattice, i)
                .ok_or(Error::NoLatticeCell { particle: i })?;
            *h = ratio * (determinant(&edges).abs() / whitening.determinant()).powf(1.0 / D as f64);
        }
        Ok(())
    }

    /// `h_i = h_0i (V_i / V_0i)^(1/D)` (eq 20), and the largest relative change.
    pub(crate) fn update_smoothing_lengths(&mut self, volume: &[f64]) -> f64 {
        let mut largest_change = 0.0_f64;
        for (i, volume) in volume.iter().enumerate() {
            let updated = self.smoothing_by_volume(i, *volume);
            let h = &mut self.smoothing_lengths[i];
            largest_change = largest_change.max((updated / *h - 1.0).abs());
            *h = updated;
        }
        largest_change
    }

    /// `h_0i (V / V_0i)^(1/D)` (eq 20).
    pub(crate) fn smoothing_by_volume(&self, i: usize, volume: f64) -> f64 {
        self.smoothing_ratios[i] * volume.powf(1.0 / D as f64)
    }
}
